"""Answers of pairs are the C++ answers, bit for bit: `tandem query` prints all digits."""

import pathlib
import tempfile
import unittest

import numpy as np
import tandem

import records


def placed(record):
    return (
        records.shape(record["shapeA"]),
        records.pose(record["poseA"]),
        records.shape(record["shapeB"]),
        records.pose(record["poseB"]),
    )


def exact_rotations(record):
    """Whether the rotations are such but for rounding; the program reads others as written, poses of the engine are rotations."""
    for name in ("poseA", "poseB"):
        rotation = np.array(record[name].get("R", np.eye(3)))
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-15:
            return False
        if "q" in record[name] and abs(np.linalg.norm(record[name]["q"]) - 1) > 1e-15:
            return False
    return True


class Pairs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.records = [
            dict(r, ask=["collide", "distance", "penetration", "normal", "contacts"])
            for r in records.records()
            if exact_rotations(r)
        ]
        cls.answers = records.query(cls.records)

    def test_mesh_files(self):
        off = "OFF\n4 4 6\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "wedge.off"
            path.write_text(off)
            solid = tandem.read_mesh(path, solid=True)
            self.assertEqual((solid.is_solid, solid.vertices.shape, len(solid.triangles)), (True, (4, 3), 4))
            path.write_text(off.replace("4 4 6", "4 3 6"))
            self.assertFalse(tandem.read_mesh(path).is_solid)
            with self.assertRaisesRegex(ValueError, r"wedge.off: mesh: solid, but not closed: the edge \(2, 0, 0\)"):
                tandem.read_mesh(str(path), solid=True)

    def test_all_records_are_answered_as_by_the_program(self):
        self.assertEqual(len(self.records), len(self.answers))
        compared = 0
        for record, expected in zip(self.records, self.answers):
            with self.subTest(id=record["id"]):
                self.assertEqual(record["id"], expected["id"])
                if "error" in expected:
                    with self.assertRaises(ValueError):
                        tandem.contacts(*placed(record))
                    continue
                answer = tandem.distance(*placed(record))
                self.assertEqual(answer.signed_distance, expected["signed_distance"])
                self.assertEqual(answer.status, expected["status"])
                self.assertEqual(tandem.collide(*placed(record)), expected["collide"])
                self.assertEqual([answer.point_a.tolist(), answer.point_b.tolist()], expected["points"])
                self.assertEqual(answer.normal.tolist(), expected["normal"])
                found = tandem.contacts(*placed(record), margin=record.get("margin", 0.0))
                listed = expected.get("contacts", [])
                self.assertEqual(len(found), len(listed))
                for mine, theirs in zip(found, listed):
                    self.assertEqual(mine["point"].tolist(), theirs["point"])
                    self.assertEqual(mine["normal"].tolist(), theirs["normal"])
                    self.assertEqual(float(mine["depth"]), theirs["depth"])
                compared += 1
        self.assertGreater(compared, 200)

    def test_intersecting_triangles_are_those_of_the_program(self):
        asked = [
            dict(r, ask=["triangles_intersect"])
            for r in records.records()
            if "triangles_intersect" in r["ask"] and r["shapeA"]["kind"] == r["shapeB"]["kind"] == "mesh"
        ]
        for record, expected in zip(asked, records.query(asked)):
            found = tandem.intersecting_triangles(*placed(record))
            self.assertEqual(found.dtype, np.uint32)
            self.assertEqual(found.tolist(), expected["triangles"])

    def test_first_touch_of_two_spheres(self):
        ball = tandem.Sphere(1)
        to = np.eye(4)
        to[0, 3] = 10
        touch = tandem.time_of_impact(ball, None, to, ball, [5, 0, 0, 1, 0, 0, 0], [5, 0, 0, 1, 0, 0, 0])
        self.assertAlmostEqual(touch.t, 0.3, places=12)
        np.testing.assert_allclose(touch.point, [4, 0, 0], atol=1e-12)
        self.assertIsNone(tandem.time_of_impact(ball, None, None, ball, [5, 0, 0, 1, 0, 0, 0], [5, 0, 0, 1, 0, 0, 0]))

    def test_cutoff_and_tolerance(self):
        ball = tandem.Sphere(1)
        far = tandem.distance(ball, None, ball, [5, 0, 0, 1, 0, 0, 0], cutoff=1)
        self.assertTrue(far.farther)
        self.assertEqual(far.signed_distance, 1)
        with self.assertRaisesRegex(ValueError, "tolerance"):
            tandem.distance(ball, None, ball, None, tolerance=0.5)

    def test_triangles_of_contacts_lie_where_the_contacts_do(self):
        vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float)
        sheet = tandem.Mesh(vertices, [[0, 1, 2], [1, 3, 2]])
        ball, at = tandem.Sphere(0.2), [0.9, 0.9, 0.1, 1, 0, 0, 0]
        self.assertEqual(tandem.triangles_at(sheet, None, ball, at, tandem.distance(sheet, None, ball, at)), (1, 0))
        found = tandem.contacts(sheet, None, ball, at)
        np.testing.assert_array_equal(tandem.triangles_at(sheet, None, ball, at, found), [[1, 0]] * len(found))


if __name__ == "__main__":
    unittest.main()
