"""Voxels, solids of meshes that do not close, winding numbers, and how the building of a mesh is watched and ended."""

import pathlib
import tempfile
import unittest

import numpy as np
import tandem

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
CUBE = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)


def sheet(side):
    """A wavy square of 2 side^2 triangles."""
    steps = np.linspace(0, 1, side + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(steps, steps))
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    triangles = [[first, first + 1, first + side + 2], [first, first + side + 2, first + side + 1]]
    return np.stack([x, y, 0.1 * np.sin(7 * x)], 1), np.concatenate([np.stack(t, 1) for t in triangles])


class Voxels(unittest.TestCase):
    def test_a_bar_of_cells(self):
        bar = tandem.voxels([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [0, 0, 0]], 0.5)
        self.assertTrue(bar.is_solid)
        self.assertAlmostEqual(bar.volume, 3 * 0.125)
        np.testing.assert_allclose(bar.bounds(), [[-0.5, 0, 0], [1, 0.5, 0.5]])
        self.assertEqual((bar.kind, len(bar.cells), len(bar.triangles)), ("voxels", 3, 0))
        np.testing.assert_allclose(bar.parameters, [0, 0, 0, 0.5])
        mesh = tandem.voxel_mesh([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [0, 0, 0]], 0.5)
        self.assertEqual(len(mesh.triangles), 2 * 14)
        ball = tandem.Sphere(0.1)
        self.assertAlmostEqual(tandem.distance(bar, None, ball, [2, 0.25, 0.25, 1, 0, 0, 0]).signed_distance, 0.9)
        self.assertTrue(tandem.collide(bar, None, ball, [0.25, 0.25, 0.25, 1, 0, 0, 0]))

    def test_what_a_sensor_saw(self):
        seen = np.random.default_rng(1).uniform(-2, 2, (3000, 3))
        cells = np.floor(seen / 0.2).astype(int)
        shape = tandem.voxels(cells, 0.2)
        self.assertAlmostEqual(shape.volume, len(np.unique(cells, axis=0)) * 0.008, places=9)
        for point in seen[:50]:
            self.assertTrue(tandem.collide(shape, None, tandem.Sphere(0), [*point, 1, 0, 0, 0]))

    def test_levels_and_dense_grids(self):
        large = tandem.voxels([[0, 0, 0, 3]], 0.25, [1, 2, 3])
        full = tandem.occupancy_grid(np.ones((8, 8, 8)), 0.25, [1, 2, 3])
        np.testing.assert_array_equal(large.cells, [[0, 0, 0, 3]])
        np.testing.assert_array_equal(full.cells, large.cells)
        np.testing.assert_allclose(full.bounds(), [[1, 2, 3], [3, 4, 5]])
        seen = np.zeros((2, 3, 4), bool)
        seen[1, 2, 0] = seen[0, 0, 3] = True
        self.assertEqual({tuple(c[:3]) for c in tandem.occupancy_grid(seen, 1).cells}, {(0, 2, 1), (3, 0, 0)})

    def test_octomap(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "map.bt"
            header = b"# Octomap OcTree binary file\nid OcTree\nsize 2\nres 0.5\ndata\n"
            path.write_bytes(header + b"\x02\x80")
            shape = tandem.read_octomap(path)
            np.testing.assert_array_equal(shape.cells, [[-32768] * 3 + [15], [0, 0, 0, 15]])
            self.assertEqual(shape.parameters[3], 0.5)
            path.write_bytes(header + b"\x03")
            with self.assertRaisesRegex(ValueError, "map.bt: byte"):
                tandem.read_octomap(path)
            path.write_bytes(header + b"\x01\x00")
            with self.assertRaisesRegex(ValueError, "map.bt: voxels: cells is empty"):
                tandem.read_octomap(path)

    def test_refusals(self):
        with self.assertRaisesRegex(ValueError, "level 21"):
            tandem.voxels([[0, 0, 0, 21]], 1)
        with self.assertRaisesRegex(ValueError, "occupied"):
            tandem.occupancy_grid(np.ones((2, 2)), 1)
        for cells, size, message in [
            ([[0, 0, 0]], 0, "size"),
            ([[0, 0, 0]], np.nan, "size"),
            (np.zeros((0, 3), int), 1, "cell"),
            ([[0, 0]], 1, "cells"),
            ([[0.5, 0, 0]], 1, "cells"),
            ([[2**40, 0, 0]], 1, r"cells: 1099511627776 in row 0"),
            ([[2**21, 0, 0]], 1, "cell"),
        ]:
            with self.assertRaisesRegex(ValueError, message):
                tandem.voxels(cells, size)
        for cells, size in [(np.zeros((0, 3), int), 1), ([[0, 0, 0]], -1), ([[2**20, 0, 0]], 1)]:
            with self.assertRaisesRegex(ValueError, "voxel_mesh: "):
                tandem.voxel_mesh(cells, size)


class Winding(unittest.TestCase):
    def test_of_a_cube(self):
        winding = tandem.WindingNumber(CORNERS, CUBE)
        inside = np.random.default_rng(2).uniform(0.01, 0.99, (100, 3))
        np.testing.assert_allclose(winding.at(inside), 1, atol=1e-12)
        np.testing.assert_allclose(winding.at(inside + [2, 0, 0]), 0, atol=1e-12)
        self.assertEqual(winding.at(np.zeros((0, 3))).shape, (0,))

    def test_with_a_hole(self):
        """From the middle a cube's face is a sixth of all that is seen."""
        winding = tandem.WindingNumber(CORNERS, CUBE[2:])
        np.testing.assert_allclose(winding.at([[0.5, 0.5, 0.5]]), 5 / 6, atol=1e-12)

    def test_refusals(self):
        winding = tandem.WindingNumber(CORNERS, CUBE)
        for places in ([0, 0, 0], [[0, 0]], [[0, 0, 0], [0, np.nan, 0]], "here"):
            with self.assertRaisesRegex(ValueError, "places"):
                winding.at(places)
        with self.assertRaisesRegex(ValueError, "triangles"):
            tandem.WindingNumber(CORNERS, [[0, 1, 8]])

    def test_a_solid_of_an_open_mesh(self):
        with self.assertRaisesRegex(ValueError, "edge|solid"):
            tandem.Mesh(CORNERS, CUBE[2:], solid=True)
        solid = tandem.voxel_solid(CORNERS, CUBE[2:], 0.125)
        self.assertTrue(solid.is_solid)
        self.assertLess(abs(solid.volume - 1), 0.2)
        self.assertTrue(tandem.collide(solid, None, tandem.Sphere(0), [0.4, 0.5, 0.5, 1, 0, 0, 0]))
        for options, message in [({"size": 0}, "size"), ({"size": 0.1, "most_cells": 10}, "cells"), ({"size": 0.1, "least": np.nan}, "least")]:
            with self.assertRaisesRegex(ValueError, message):
                tandem.voxel_solid(CORNERS, CUBE, **options)
        with self.assertRaises(TimeoutError):
            tandem.voxel_solid(*sheet(40), 0.002, timeout=0)


class Building(unittest.TestCase):
    def test_progress_is_told_and_changes_nothing(self):
        vertices, triangles = sheet(150)
        told = []
        watched = tandem.Mesh(vertices, triangles, progress=told.append)
        self.assertEqual(told[-1], 1)
        self.assertEqual(told, sorted(told))
        self.assertGreater(min(told), 0)
        plain, other = tandem.Mesh(vertices, triangles), tandem.Box([0.3, 0.3, 0.3])
        at = [0.5, 0.5, 0.3, 1, 0, 0, 0]
        for shape in (watched, plain):
            np.testing.assert_array_equal(
                tandem.contacts(shape, None, other, at, margin=0.1), tandem.contacts(plain, None, other, at, margin=0.1)
            )

    def test_what_is_raised_ends_the_work(self):
        def enough(part):
            raise KeyError(f"at {part > 0}")

        with self.assertRaisesRegex(KeyError, "at True"):
            tandem.Mesh(*sheet(100), progress=enough)

    def test_a_timeout(self):
        with self.assertRaises(TimeoutError):
            tandem.Mesh(*sheet(100), timeout=0)
        self.assertEqual(tandem.Mesh(*sheet(2), timeout=60).triangles.shape, (8, 3))
        for bad in (-1, np.nan):
            with self.assertRaisesRegex(ValueError, "timeout"):
                tandem.Mesh(*sheet(2), timeout=bad)
        with self.assertRaisesRegex(ValueError, "progress.*function"):
            tandem.Mesh(*sheet(2), progress=1)

    def test_memory_by_part(self):
        shape = tandem.Mesh(*sheet(20))
        self.assertEqual(sum(shape.memory_by_part.values()), shape.memory)
        self.assertGreaterEqual(shape.memory_by_part["surface"], 800 * 12)
        self.assertEqual(tandem.memory_of([shape, shape]), tandem.memory_of([shape]))
        self.assertGreaterEqual(tandem.memory_of([shape]), shape.memory)

    def test_what_a_shape_is(self):
        box = tandem.Box([1, 2, 4])
        np.testing.assert_array_equal(box.parameters[:3], [0.5, 1, 2])
        np.testing.assert_allclose(box.inertia, 8 / 12 * np.diag([20, 17, 5]))
        self.assertTrue(box.is_convex and box.is_bounded)
        self.assertFalse(tandem.HalfSpace([0, 0, 1]).is_bounded)
        self.assertFalse(tandem.Mesh(CORNERS, CUBE).is_convex)


if __name__ == "__main__":
    unittest.main()
