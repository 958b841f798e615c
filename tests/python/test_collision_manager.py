"""trimesh's names: who used its collision manager changes an import."""

import types
import unittest

import numpy as np
import tandem


def cube(edge=1.0):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * edge / 2
    faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ]
    return types.SimpleNamespace(vertices=corners, faces=np.array(faces))


def at(x, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = [x, y, z]
    return matrix


class Manager(unittest.TestCase):
    def setUp(self):
        self.manager = tandem.CollisionManager()
        self.manager.add_object("a", cube())
        self.manager.add_object("b", cube(), at(3))
        self.manager.add_object("c", tandem.Sphere(0.5), at(3.75))

    def test_internal(self):
        m = self.manager
        self.assertTrue(m.in_collision_internal())
        hit, names, data = m.in_collision_internal(return_names=True, return_data=True)
        self.assertEqual((hit, names), (True, {("b", "c")}))
        self.assertEqual(data[0].names, {"b", "c"})
        self.assertAlmostEqual(data[0].depth, 0.25)
        np.testing.assert_allclose(data[0].normal, [1, 0, 0], atol=1e-12)
        self.assertEqual(data[0].index("c"), 0)
        corners = m._shapes["b"].vertices[m._shapes["b"].triangles[data[0].index("b")]]
        self.assertTrue((corners[:, 0] == 0.5).all())
        m.remove_object("c")
        self.assertEqual(m.in_collision_internal(True, True), (False, set(), []))
        self.assertFalse(m.in_collision_internal())

    def test_single(self):
        m = self.manager
        self.assertFalse(m.in_collision_single(cube(), at(1.5)))
        self.assertEqual(m.in_collision_single(cube(), at(0.9), return_names=True), (True, {"a"}))
        _, data = m.in_collision_single(cube(), at(0.9), return_data=True)
        self.assertTrue(all(each.names == {"a", "__external"} for each in data))
        distance, name, data = m.min_distance_single(cube(), at(-4), return_name=True, return_data=True)
        self.assertEqual((distance, name, data.distance), (3, "a", 3))
        self.assertEqual((data.point("a")[0], data.point("__external")[0]), (-0.5, -3.5))
        self.assertEqual(tandem.CollisionManager().min_distance_single(cube()), np.inf)

    def test_distances(self):
        m = self.manager
        self.assertEqual(m.min_distance_internal(return_names=True), (-0.25, ("b", "c")))
        m.set_transform("c", at(6))
        self.assertEqual(m.min_distance_internal(return_names=True), (2.0, ("a", "b")))
        self.assertEqual(m.min_distance_internal("c", True)[1], ("c", "b"))
        other = tandem.CollisionManager()
        other.add_object("x", cube(), at(1.75))
        self.assertEqual(m.min_distance_other(other, return_names=True), (0.25, ("b", "x")))
        self.assertEqual(m.in_collision_other(other, True), (False, set()))
        other.set_transform("x", at(2.25))
        self.assertEqual(m.in_collision_other(other, True), (True, {("b", "x")}))
        self.assertTrue(m.in_collision_other(other))

    def test_refusals(self):
        for call in (self.manager.remove_object, lambda name: self.manager.set_transform(name, at(0))):
            with self.assertRaisesRegex(ValueError, "'nothing'.*a, b, c"):
                call("nothing")
        with self.assertRaisesRegex(ValueError, "vertices and faces"):
            self.manager.add_object("d", 3)
        with self.assertRaisesRegex(ValueError, "pose"):
            self.manager.add_object("a", cube(), at(np.nan))
        self.manager.add_object("a", cube(), at(10))
        self.assertEqual(self.manager.in_collision_internal(True), (True, {("b", "c")}))


if __name__ == "__main__":
    unittest.main()
