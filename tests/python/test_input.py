"""What cannot be used is refused with what is wrong, where, and what is allowed."""

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


class Calls(unittest.TestCase):
    def test_refusals(self):
        scene = tandem.Scene()
        body = scene.add_body(BALL)
        queries = tandem.SceneQueries(scene)
        at = np.tile(np.eye(4), (3, 1, 1))
        bad = [
            (lambda: tandem.Pipeline(threads=-1), "threads"),
            (lambda: tandem.Pipeline(executor="fastest"), "executor.*flowgraph"),
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


if __name__ == "__main__":
    unittest.main()
