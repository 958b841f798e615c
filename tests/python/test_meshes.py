"""Meshes: zones, near features, bending, inspection, impacts of vertices; against numpy and against one another."""

import unittest

import numpy as np
import tandem

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
# fmt: off
SIDES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                  [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
# fmt: on
RANDOM = np.random.default_rng(5)


def cube():
    return tandem.Mesh(CORNERS, SIDES, solid=True)


def at(x, y=0.0, z=0.0):
    return [x, y, z, 1, 0, 0, 0]


def plate(n, height):
    """A square of n x n cells, corners at heights."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    vertices = np.stack([x.ravel(), y.ravel(), height(x, y).ravel()], axis=1)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.concatenate(
        [np.stack([first, first + 1, first + n + 2], 1), np.stack([first, first + n + 2, first + n + 1], 1)]
    )
    return vertices, triangles


class Zones(unittest.TestCase):
    def test_two_cubes(self):
        near = tandem.near_triangles(cube(), None, cube(), at(1.25), clearance=0.25)
        self.assertEqual(set(near["distance"]), {0.25})
        self.assertTrue(np.all(near["point_a"][:, 0] == 1) and np.all(near["point_b"][:, 0] == 1.25))
        self.assertEqual(near["triangles"].tolist(), sorted(near["triangles"].tolist()))
        self.assertEqual(len(tandem.near_triangles(cube(), None, cube(), at(1.25), clearance=0.24)), 0)
        crossing = tandem.near_triangles(cube(), None, cube(), at(0.5, 0.3, 0.2))
        listed = tandem.intersecting_triangles(cube(), None, cube(), at(0.5, 0.3, 0.2))
        np.testing.assert_array_equal(crossing["triangles"], listed)
        (zone,) = tandem.clearance_zones(cube(), None, cube(), at(1.25), clearance=0.25)
        self.assertEqual((zone["pairs"], zone["intersecting_pairs"], zone["signed_distance"]), (len(near), 0, 0.25))
        self.assertEqual(zone["normal"].tolist(), [1, 0, 0])
        self.assertTrue(np.all(zone["bounds"][0] <= zone["bounds"][1]))
        self.assertAlmostEqual(tandem.separation_along(cube(), None, cube(), at(0.75), [2, 0, 0]), 0.25, delta=1e-12)
        self.assertEqual(tandem.separation_along(cube(), None, cube(), at(2), [1, 0, 0]), 0)

    def test_bounds(self):
        depth = tandem.penetration_depth(cube(), None, cube(), at(0.75, 0.1, 0), gap=0.01, most_boxes=100)
        self.assertTrue(depth.collide and depth.boxes <= 100)
        self.assertAlmostEqual(depth.lower, 0.25, delta=1e-9)
        self.assertAlmostEqual(depth.upper, 0.25, delta=1e-9)
        np.testing.assert_allclose(depth.translation, [0.25, 0, 0], atol=1e-9)
        self.assertFalse(tandem.penetration_depth(cube(), None, cube(), at(3)).collide)
        far = tandem.hausdorff_distance(cube(), None, cube(), at(0.25), tolerance=1e-6)
        self.assertTrue(far.lower <= 0.25 + 1e-9 and far.upper >= 0.25 - 1e-9 and far.upper - far.lower <= 1e-3)
        self.assertAlmostEqual(np.linalg.norm(far.point - far.nearest), far.lower, delta=1e-9)
        self.assertIsInstance(far.of_a, bool)

    def test_refused(self):
        for call in (
            lambda: tandem.clearance_zones(cube(), None, cube(), None, clearance=-1),
            lambda: tandem.near_triangles(cube(), None, tandem.Sphere(1), None),
            lambda: tandem.near_features(cube(), None, cube(), None, np.nan),
            lambda: tandem.separation_along(cube(), None, cube(), None, [0, 0, 0]),
            lambda: tandem.near_triangles(cube(), None, cube(), None, timeout=-1),
            lambda: tandem.penetration_depth(cube(), None, cube(), None, gap=2),
            lambda: tandem.hausdorff_distance(cube(), None, tandem.Sphere(1), None),
        ):
            with self.assertRaises(ValueError):
                call()


class Timeouts(unittest.TestCase):
    def test_a_pair_that_takes_long(self):
        fine = tandem.Mesh(*plate(100, lambda x, y: np.sin(x) * np.sin(y)))
        for call in (
            lambda: tandem.contacts(fine, None, fine, at(0.3, 0.2, 0.1), timeout=0),
            lambda: tandem.collide(fine, None, fine, at(0.3, 0.2, 0.1), timeout=0),
            lambda: tandem.intersecting_triangles(fine, None, fine, at(0.3, 0.2, 0.1), timeout=0),
            lambda: tandem.near_triangles(fine, None, fine, at(0.3, 0.2, 0.1), timeout=0),
            lambda: tandem.clearance_zones(fine, None, fine, at(0.3, 0.2, 0.1), timeout=0),
        ):
            with self.assertRaises(TimeoutError):
                call()
        self.assertEqual(tandem.distance(fine, None, fine, at(0, 0, 9), timeout=0).status, "stopped")
        self.assertEqual(
            tandem.distance(fine, None, fine, at(0, 0, 9), timeout=3600).signed_distance,
            tandem.distance(fine, None, fine, at(0, 0, 9)).signed_distance,
        )

    def test_a_step(self):
        scene = tandem.builtin_scene("cubes-on-plane", 200)
        pipeline = tandem.Pipeline(threads=1)
        self.assertIn("incomplete", pipeline.step(scene, timeout=0).issues)
        self.assertNotIn("incomplete", pipeline.step(scene, timeout=3600).issues)


class Features(unittest.TestCase):
    def test_points_and_edges(self):
        points, points_of_b, edges = tandem.near_features(cube(), None, cube(), at(1.5, 0.25, 0.25), 0.51)
        self.assertEqual(set(points["distance"]) | set(points_of_b["distance"]), {0.5})
        self.assertEqual({int(v) for v in points_of_b["vertex"]}, {0})
        self.assertGreater(len(edges), 0)
        self.assertTrue(np.all(edges["distance"] <= 0.51))


class Bending(unittest.TestCase):
    def test_a_sheet_that_folds(self):
        vertices, triangles = plate(12, lambda x, y: 0 * x)
        sheet = tandem.DeformableMesh(vertices, triangles)
        flat = sheet.shape()
        self.assertEqual(len(sheet.self_intersections()), 0)
        folded = vertices.copy()
        angle = folded[:, 0] * 0.55
        folded[:, 0], folded[:, 2] = np.sin(angle), np.cos(angle)  # rolled up beyond a whole turn
        self.assertIsInstance(sheet.update(folded), int)
        self.assertEqual(flat.bounds()[1, 2], 0)
        fresh = tandem.Mesh(folded, triangles)
        ball = tandem.Sphere(0.2)
        self.assertEqual(
            tandem.distance(sheet.shape(), None, ball, at(0, 5, 0)).signed_distance,
            tandem.distance(fresh, None, ball, at(0, 5, 0)).signed_distance,
        )
        self.assertGreater(len(sheet.self_intersections()), 0)
        points, _, edges = sheet.near_features(0.01)
        self.assertGreater(len(points) + len(edges), 0)
        self.assertGreater(sheet.memory, 1000)
        with self.assertRaisesRegex(ValueError, "vert"):
            sheet.update(folded[:-1])


class Inspections(unittest.TestCase):
    def test_what_is_found(self):
        found = tandem.inspect(CORNERS, SIDES)
        self.assertTrue(found.is_closed and found.is_clean_solid)
        self.assertEqual((found.vertices, found.triangles, found.components), (8, 12, 1))
        found = tandem.inspect(CORNERS, np.vstack([SIDES[1:], SIDES[1:2], [[0, 0, 1]]]), most=2)
        self.assertFalse(found.is_closed)
        count, edges = found.faulty_edges
        self.assertGreater(count, 2)
        self.assertEqual(len(edges), 2)
        self.assertEqual(edges["ends"].shape, (2, 2, 3))
        self.assertEqual(found.duplicate_triangles[0], 1)
        self.assertEqual(found.flat_triangles[1]["triangle"].tolist(), [12])
        found = tandem.inspect(CORNERS, SIDES[:, ::-1])
        self.assertEqual((found.inside_out[0], found.inside_out[1]["volume"][0]), (1, -1))
        shifted = np.vstack([CORNERS, CORNERS + 0.5])
        found = tandem.inspect(shifted, np.vstack([SIDES, SIDES + 8]))
        crossing = tandem.intersecting_triangles(cube(), None, cube(), at(0.5, 0.5, 0.5))
        self.assertEqual(found.self_intersections[0], len(crossing))


class Impacts(unittest.TestCase):
    def test_against_the_cubic(self):
        """A point through a triangle and an edge through an edge, whose times are known; many at once."""
        count = 200
        corners = RANDOM.uniform(-1, 1, (count, 3, 3))
        inside = RANDOM.dirichlet([1, 1, 1], count)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        target = np.einsum("ni,nij->nj", inside, corners)
        time = RANDOM.uniform(0.1, 0.9, count)
        velocity = normal + RANDOM.uniform(-0.1, 0.1, (count, 3))
        start, end = target - velocity * time[:, None], target + velocity * (1 - time[:, None])
        vertices = corners.reshape(-1, 3)
        pairs = np.column_stack([np.arange(count), np.arange(3 * count).reshape(-1, 3)])
        hits = tandem.point_triangle_impacts(start, end, vertices, vertices, pairs)
        self.assertTrue(hits["hit"].all())
        self.assertTrue(np.all(hits["t"] <= time + 1e-12))
        self.assertLess(np.abs(hits["t"] - time).max(), 1e-5)
        away = tandem.point_triangle_impacts(start, start - velocity, vertices, vertices, pairs)
        self.assertFalse(away["hit"].any())
        # An edge that rises through another, from 1 below it to 3 above it.
        a_from = np.array([[-1.0, 0, -1], [1, 0, -1]])
        b = np.array([[0.0, -1, 0], [0, 1, 0]])
        (hit,) = tandem.edge_edge_impacts(a_from, a_from + [0, 0, 4], b, b, [[0, 1, 0, 1]])
        self.assertTrue(hit["hit"])
        self.assertAlmostEqual(hit["t"], 0.25, delta=1e-5)

    def test_refused(self):
        with self.assertRaisesRegex(ValueError, r"pairs: an array of shape \(1, 3\), allowed: \(n, 4\)"):
            tandem.point_triangle_impacts(CORNERS, CORNERS, CORNERS, CORNERS, [[0, 1, 2]])
        with self.assertRaises(ValueError):
            tandem.point_triangle_impacts(CORNERS, CORNERS, CORNERS, CORNERS, [[0, 1, 2, 99]])
        with self.assertRaises(ValueError):
            tandem.point_triangle_impacts(CORNERS, CORNERS * np.nan, CORNERS, CORNERS, [[0, 1, 2, 3]])


class Motions(unittest.TestCase):
    def test_a_bullet_is_stopped_by_a_thin_plate(self):
        scene = tandem.Scene()
        plate_id = scene.add_body(tandem.Box([2, 2, 0.01]), is_static=True)
        bullet = scene.add_body(tandem.Sphere(0.05), at(0, 0, 1), velocity=[0, 0, -1000], continuous=True)
        ends = tandem.free_ends(scene)
        self.assertAlmostEqual(ends[scene.index(bullet), 2, 3], 1 - 1000 * scene.dt)
        limited, stops = tandem.limit_motion(scene, ends)
        self.assertAlmostEqual(limited[scene.index(bullet), 2, 3], 0.055, delta=1e-6)
        self.assertEqual((stops["a"].tolist(), stops["b"].tolist()), ([plate_id], [bullet]))
        self.assertEqual(stops["normal"].tolist(), [[0, 0, 1]])
        with self.assertRaisesRegex(ValueError, "ends"):
            tandem.limit_motion(scene, ends[:1])


if __name__ == "__main__":
    unittest.main()
