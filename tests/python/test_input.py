"""What cannot be used is refused with what is wrong, where, and what is allowed."""

import collections
import unittest

import numpy as np
import tandem

BALL = tandem.Sphere(1)
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], float)


class Poses(unittest.TestCase):
    def refused(self, pose, message):
        for call in (lambda: tandem.distance(BALL, None, BALL, pose), lambda: tandem.Scene().add_body(BALL, pose)):
            with self.assertRaisesRegex(ValueError, message):
                call()

    def test_shapes_and_kinds(self):
        self.refused(np.eye(3), r"pose.*\(4, 4\)")
        self.refused([0, 0, 0], r"pose.*\(7\)")
        self.refused("here", "pose")
        self.refused({"t": 0}, "pose")
        self.refused(np.eye(4) * 1j, "pose")
        self.refused([[1, 2], [3]], "pose")

    def test_numbers(self):
        for bad in (np.nan, np.inf, -np.inf):
            for place in ((0, 0), (1, 3), (3, 2)):
                pose = np.eye(4)
                pose[place] = bad
                self.refused(pose, "pose")
        self.refused(np.diag([2.0, 1, 1, 1]), "pose")
        self.refused(np.diag([-1.0, 1, 1, 1]), "pose")
        last_row = np.eye(4)
        last_row[3] = [0, 0, 1, 1]
        self.refused(last_row, "pose")
        self.refused([0, 0, 0, 0, 0, 0, 0], "pose")
        self.refused([np.nan, 0, 0, 1, 0, 0, 0], "pose")

    def test_any_layout_is_read(self):
        at = np.eye(4)
        at[:3, 3] = [1.5, 2, 3]
        big = np.zeros((8, 8))
        big[::2, ::2] = at
        same = [
            at,
            at.astype(np.float32),
            np.asfortranarray(at),
            big[::2, ::2],
            at.tolist(),
            at.astype(">f8"),
            [1.5, 2, 3, 1, 0, 0, 0],
            (1.5, 2, 3, -1, 0, 0, 0),
        ]
        expected = tandem.distance(BALL, None, BALL, at).signed_distance
        for pose in same:
            self.assertEqual(tandem.distance(BALL, None, BALL, pose).signed_distance, expected)
        whole = np.eye(4, dtype=int)
        whole[0, 3] = 3
        self.assertEqual(tandem.distance(BALL, None, BALL, whole).signed_distance, 1)


class Shapes(unittest.TestCase):
    def test_refusals(self):
        bad = [
            (lambda: tandem.Sphere(-1), "radius"),
            (lambda: tandem.Sphere(np.nan), "radius"),
            (lambda: tandem.Box([1, 0, 1]), "size"),
            (lambda: tandem.Box([1, 1]), "size"),
            (lambda: tandem.HalfSpace([0, 0, 0]), "normal"),
            (lambda: tandem.Plane([0, 0, 0]), "normal"),
            (lambda: tandem.voxels([[0, 0, 0.5]], 1), "cells"),
            (lambda: tandem.Convex(np.zeros((0, 3))), "vertices"),
            (lambda: tandem.Convex(np.zeros((3, 2))), "vertices"),
            (lambda: tandem.Mesh(SQUARE, [[0, 1, 3]]), "triangles"),
            (lambda: tandem.Mesh(SQUARE, [[0, 1, -1]]), "triangles"),
            (lambda: tandem.Mesh(SQUARE, [[0, 1, 1.5]]), "triangles"),
            (lambda: tandem.Mesh(SQUARE, [[0, 1]]), "triangles"),
            (lambda: tandem.Mesh(SQUARE * np.nan, [[0, 1, 2]]), "vertices"),
            (lambda: tandem.Mesh(SQUARE, [[0, 1, 2]], solid=True), "solid|edge"),
            (lambda: tandem.Triangle(SQUARE[:2]), "vertices"),
            (lambda: tandem.point_cloud(SQUARE, -1), "radius"),
            (lambda: tandem.height_field([1, 2], 1, 0), "heights"),
            (lambda: tandem.height_field([[1, np.inf], [2, 3]], 1, 0), "height"),
            (lambda: tandem.read_mesh("/nowhere/part.stl"), "/nowhere/part.stl"),
            (lambda: tandem.builtin_scene("nothing"), "nothing"),
        ]
        for call, message in bad:
            with self.assertRaisesRegex(ValueError, message):
                call()

    def test_planes_and_voxels(self):
        self.assertAlmostEqual(tandem.distance(tandem.Plane([0, 0, 2], 4), None, BALL, None).signed_distance, 1)
        bounds = tandem.voxels([[0, 0, 0], [-1, 2, 0]], 0.5).bounds()
        np.testing.assert_allclose(bounds, [[-0.5, 0, 0], [0.5, 1.5, 0.5]])

    def test_meshes_take_any_whole_numbers(self):
        for kind in (np.int8, np.int32, np.uint32, np.int64, np.uint64):
            self.assertEqual(tandem.Mesh(SQUARE, np.array([[0, 1, 2]], kind)).triangles.tolist(), [[0, 1, 2]])
        np.testing.assert_array_equal(tandem.Mesh(SQUARE.astype(np.float32), [[0, 1, 2]]).vertices, SQUARE)


    def test_whole_numbers_beyond_64_bits_with_a_sign(self):
        for last in (2**63, 2**64 - 1):
            cells = np.array([[0, 0, last]], np.uint64)
            with self.assertRaisesRegex(ValueError, f"cells: {last} in row 0, allowed: "):
                tandem.voxels(cells, 1)
            with self.assertRaisesRegex(ValueError, f"triangles: {last} in row 0, allowed: "):
                tandem.Mesh(SQUARE, cells)


class Messages(unittest.TestCase):
    def test_are_one_short_line_whatever_is_quoted(self):
        name = "x" * 3000
        scene = tandem.Scene()
        odd = type(name, (), {})()
        fields = np.zeros(3, [(f"field{i}", float) for i in range(100)])
        bad = [
            lambda: tandem.Pipeline(executor=name),
            lambda: tandem.distance(BALL, None, BALL, None, solver=name),
            lambda: tandem.builtin_scene(name),
            lambda: tandem.overlapping_boxes(np.zeros((0, 2, 3)), method=name),
            lambda: tandem.Recording(name, scene),
            lambda: tandem.Recording("", scene),
            lambda: tandem.write_scene(name, scene),
            lambda: tandem.write_scene("", scene),
            lambda: scene.add_body(-(10**4000)),
            lambda: scene.add_body(odd),
            lambda: tandem.distance(BALL, fields, BALL, None),
            lambda: tandem.distance(odd, None, BALL, None),
            lambda: tandem.distance(BALL, None, BALL, None, **{name: 1}),
            lambda: tandem.distance(BALL, None, BALL, None, tolerance=-1e308),
            lambda: tandem.distance(BALL, None, BALL, None, timeout=-1e308),
            lambda: tandem.pose_at(None, None, 1e308),
            lambda: tandem.height_field([[1, 2], [1, 2]], -1e308, 0),
            lambda: tandem.overlapping_boxes([[[1e308, 0, 0], [-1e308, 0, 0]]]),
        ]
        for number, call in enumerate(bad):
            with self.subTest(number=number), self.assertRaises((ValueError, TypeError)) as caught:
                call()
            self.assertLess(len(str(caught.exception)), 300)
            self.assertNotIn("\n", str(caught.exception))

    def test_tell_the_number_that_was_given(self):
        for call, number in (
            (lambda: tandem.distance(BALL, None, BALL, None, tolerance=0.1 + 1e-9), "0.100000001"),
            (lambda: tandem.distance(BALL, None, BALL, None, timeout=-1e-9), "-1e-09"),
            (lambda: tandem.pose_at(None, None, 1 + 1e-9), "1.000000001"),
            (lambda: tandem.penetration_depth(BALL, None, BALL, None, gap=-1e-9), "-1e-9"),
            (lambda: tandem.overlapping_boxes([[[1e-9, 0, 0], [0, 0, 0]]]), "from 1e-09 to 0"),
        ):
            with self.assertRaisesRegex(ValueError, number):
                call()


class Calls(unittest.TestCase):
    def test_refusals(self):
        scene = tandem.Scene()
        body = scene.add_body(BALL)
        queries = tandem.SceneQueries(scene)
        at = np.tile(np.eye(4), (3, 1, 1))
        bad = [
            (lambda: tandem.Pipeline(threads=-1), "threads"),
            (lambda: tandem.Pipeline(executor="fastest"), "executor.*flowgraph"),
            (lambda: tandem.Pipeline(split=(2**31 - 1, 2**31 - 1)), "balance.split"),
            (lambda: tandem.Pipeline(margin=np.nan), "margin"),
            (lambda: tandem.Response(substeps=0), "substeps"),
            (lambda: scene.add_body("ball"), "shape"),
            (lambda: scene.add_body(12345), "shape"),
            (lambda: scene.add_body(BALL, density=-1), "density"),
            (lambda: scene.add_body(BALL, velocity=[0, np.inf, 0]), "velocity"),
            (lambda: scene.add_bodies(BALL, at * np.nan), "poses"),
            (lambda: scene.set_poses([body], at), "poses"),
            (lambda: scene.set_poses([0.5], at[:1]), "ids"),
            (lambda: scene.remove_body(77), "body|id"),
            (lambda: queries.collides(BALL, margin=-1), "margin"),
            (lambda: queries.check([], at), "links"),
            (lambda: queries.check([BALL, BALL], at), "poses"),
            (lambda: queries.check([BALL], at, timeout=-1), "timeout"),
            (lambda: queries.check([BALL], at, configurations_a_motion=0), "configurations_a_motion"),
            (lambda: queries.check([BALL], at, self_pairs=[True]), "self_pairs"),
            (lambda: queries.check([BALL], at, world_pairs=np.zeros((2, 1), bool)), "table of bodies"),
            (lambda: queries.check([BALL], at * np.nan), "poses"),
            (lambda: queries.clearance([BALL], at, cutoff=np.nan), "cutoff"),
            (lambda: tandem.triangles_at(BALL, None, BALL, None, np.zeros(3)), "of: "),
        ]
        for number, (call, message) in enumerate(bad):
            with self.subTest(number=number), self.assertRaisesRegex(ValueError, message):
                call()
        self.assertEqual(len(scene), 1)

    def test_motions_times_and_ids(self):
        motion = (BALL, None, [4, 0, 0, 0, 0, 1, 0], BALL, None, None)
        for bad in ([np.nan, 0, 0], [np.inf, 0, 0], [0, 2e30, 0]):
            with self.assertRaisesRegex(ValueError, r"motion of A: straight_of\[\d\] is .*finite"):
                tandem.time_of_impact(*motion, straight_of_a=bad)
            with self.assertRaisesRegex(ValueError, r"straight_of\[\d\] is .*finite"):
                tandem.pose_at(None, None, 0.5, straight_of=bad)
        scene = tandem.Scene()
        scene.add_body(BALL)
        for bad in (np.nan, np.inf, 0.0, -1.0, 2000.0):
            with self.assertRaisesRegex(ValueError, "dt: .*allowed: > 0, at most 1000 s"):
                scene.dt = bad
        with self.assertRaisesRegex(ValueError, "gravity: not finite"):
            scene.gravity = [0, np.nan, 0]
        for bad in (-1, 2**64):
            with self.assertRaisesRegex(ValueError, "shape: .*allowed: an id"):
                scene.add_body(bad)

    def test_contacts_of_another_scene(self):
        scene, pipeline = tandem.Scene(), tandem.Pipeline(threads=1)
        ids = scene.add_bodies(BALL, [[1.5 * i, 0, 0, 1, 0, 0, 0] for i in range(3)])
        pipeline.step(scene)
        with self.assertRaisesRegex(ValueError, "response: contacts of body 0, which does not exist"):
            tandem.Response(threads=1).step(tandem.Scene(), pipeline)
        scene.remove_body(ids[1])
        with self.assertRaisesRegex(ValueError, "response: contacts of body 1, which does not exist"):
            tandem.Response(threads=1).step(scene, pipeline)

    def test_self_pairs_name_a_pair_either_way(self):
        queries = tandem.SceneQueries(tandem.Scene())
        both = np.stack([np.eye(4), np.eye(4)])[None]
        for pair in ((0, 1), (1, 0)):
            table = np.zeros((2, 2), bool)
            table[pair] = True
            self.assertEqual(queries.check([BALL, BALL], both, self_pairs=table).tolist(), [1])

    def test_an_inspection_that_takes_too_long(self):
        fan = np.vstack([[0, 0, 0], [[np.cos(x), np.sin(x), 0.1 * np.sin(9 * x)] for x in np.linspace(0, 6, 20000)]])
        sides = [[0, i, i + 1] for i in range(1, 20000)]
        with self.assertRaises(TimeoutError):
            tandem.inspect(fan, sides, timeout=0.01)

    def test_a_scene_that_is_gone_leaves_its_queries(self):
        scene = tandem.Scene()
        body = scene.add_body(BALL)
        queries, pipeline = tandem.SceneQueries(scene), tandem.Pipeline(threads=1)
        scene.add_body(BALL, [1, 0, 0, 1, 0, 0, 0])
        pipeline.step(scene)
        contacts = pipeline.contacts()
        shape = scene.shape_of(body)
        del scene, pipeline
        self.assertEqual(queries.hits(shape).tolist(), [body])
        self.assertEqual(contacts["depth"].tolist(), [1.0])

    def test_a_type_error_is_one_line_that_names_the_argument(self):
        scene = tandem.Scene()
        queries = tandem.SceneQueries(scene)
        at = np.eye(4)
        bad = [
            (lambda: tandem.Sphere("1"), "Sphere: radius: str '1', expected: float"),
            (lambda: tandem.Sphere(), "Sphere: radius: missing, expected: float"),
            (lambda: tandem.Sphere(1, 2), "Sphere: 2 arguments by their places, expected: radius"),
            (lambda: tandem.Sphere(1, radius=2), "Sphere: radius: given twice, by its place and by its name"),
            (lambda: tandem.Sphere(size=2), "Sphere: radius: missing, expected: float"),
            (lambda: tandem.distance(BALL, at, at, at), "distance: b: an array of shape (4, 4), expected: Shape"),
            (lambda: tandem.distance(BALL, None, BALL), "distance: pose_b: missing, expected: object"),
            (
                lambda: tandem.collide(BALL, None, BALL, None, tolerance=0.1),
                "collide: tolerance: no such argument, expected: a, pose_a, b, pose_b, solver, timeout",
            ),
            (
                lambda: tandem.collide(BALL, None, BALL, None, "gjk"),
                "collide: 5 arguments by their places, expected: a, pose_a, b, pose_b; by name: solver, timeout",
            ),
            (lambda: tandem.collide(BALL, None, BALL, None, timeout="1"), "collide: timeout: str '1', expected: float, or None"),
            (lambda: tandem.SceneQueries(BALL), "SceneQueries: scene: Shape, expected: Scene"),
            (lambda: tandem.SceneQueries(scene, 1), "SceneQueries: 2 arguments by their places, expected: scene; by name: tolerance, solver"),
            (lambda: queries.collides(at), "collides: shape: an array of shape (4, 4), expected: Shape"),
            (lambda: queries.check(BALL, at), "check: links: Shape, expected: sequence of Shape"),
            (
                lambda: queries.check([BALL, None], at),
                "check: links: a sequence whose item 1 is None, expected: sequence of Shape",
            ),
            (lambda: queries.check([BALL], [at], continuous="no"), "check: continuous: str 'no', expected: bool"),
            (
                lambda: queries.collides(BALL, mask=-1),
                "collides: a number out of range or a value that does not fit, expected: shape: Shape, pose: object, margin: "
                "float, group: int, mask: int, ignore: object",
            ),
            (lambda: tandem.Pipeline().step(queries), "step: scene: SceneQueries, expected: Scene"),
        ]
        for call, message in bad:
            with self.subTest(message=message), self.assertRaises(TypeError) as caught:
                call()
            self.assertEqual(str(caught.exception), message)

    def test_what_new_made_without_init_is_refused(self):
        tried = 0
        for kind in vars(tandem._tandem).values():
            if not isinstance(kind, type) or issubclass(kind, Exception):
                continue
            empty = kind.__new__(kind)
            for name in dir(kind):
                if name.startswith("__"):
                    continue
                with self.subTest(kind=kind.__name__, name=name), self.assertRaisesRegex(TypeError, "made by __new__ alone"):
                    member = getattr(empty, name)
                    if not callable(member):
                        raise TypeError("made by __new__ alone: a constant of the class")
                    member()
                tried += 1
        self.assertGreater(tried, 50)
        with self.assertRaisesRegex(TypeError, "made by __new__ alone"):
            tandem.Pipeline().step(tandem.Scene.__new__(tandem.Scene))
        with self.assertRaisesRegex(TypeError, "made by __new__ alone"):
            tandem.distance(BALL, None, b=tandem.Shape.__new__(tandem.Shape), pose_b=None)

    def test_what_new_made_is_refused_in_sequences(self):
        scene = tandem.Scene()
        scene.add_body(BALL)
        queries, at = tandem.SceneQueries(scene), np.tile(np.eye(4), (2, 1, 1))
        for empty in ([tandem.Shape.__new__(tandem.Shape)], (BALL, tandem.Shape.__new__(tandem.Shape))):
            calls = [
                lambda: tandem.memory_of(empty),
                lambda: tandem.memory_of(shapes=empty),
                lambda: tandem.memory_of(collections.UserList(empty)),
                lambda: queries.check(empty, at),
                lambda: queries.check(links=empty, poses=at),
                lambda: queries.first_hits(empty, at),
                lambda: queries.clearance(empty, at),
            ]
            for number, call in enumerate(calls):
                with self.subTest(number=number), self.assertRaisesRegex(TypeError, "made by __new__ alone"):
                    call()

    def test_what_new_made_of_several_classes_is_refused(self):
        class Both(tandem.Scene, tandem.Pipeline):
            pass

        empty = Both.__new__(Both)
        for call in (lambda: tandem.Pipeline().step(empty), lambda: len(empty), lambda: empty.memory):
            with self.assertRaisesRegex(TypeError, "made by __new__ alone"):
                call()


if __name__ == "__main__":
    unittest.main()
