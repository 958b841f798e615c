"""Steps of scenes: contacts are the C++ contacts, bit for bit; what is kept, recorded and traced."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import tandem

from records import PROGRAM


def hashes(scene, steps, **options):
    """Of steps that a response moves, as `tandem run` does."""
    pipeline = tandem.Pipeline(contact_hash=True, margin=tandem.recommended_margin(scene), **options)
    response = tandem.Response()
    out = []
    for _ in range(steps):
        out.append(pipeline.step(scene).contact_hash)
        response.step(scene, pipeline)
    return out


class Steps(unittest.TestCase):
    def test_hashes_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            report = pathlib.Path(folder) / "run.jsonl"
            subprocess.run(
                [PROGRAM, "run", "screws-in-bowl", "--bodies", "120", "--steps", "12", "--json", report],
                check=True,
                capture_output=True,
            )
            steps = [json.loads(line) for line in report.read_text().splitlines()]
        expected = [int(step["contact_hash"], 16) for step in steps if "contact_hash" in step]
        self.assertEqual(len(expected), 12)
        for executor in ("sequential", "barrier", "fused", "threads", "flowgraph"):
            scene = tandem.builtin_scene("screws-in-bowl", 120)
            self.assertEqual(hashes(scene, 12, executor=executor, threads=3), expected)

    def test_how_steps_are_run_changes_no_answer(self):
        expected = hashes(tandem.builtin_scene("cubes-on-plane", 80), 6)
        for options in (
            {"form": "ordered", "short_step_ms": 0, "threads": 2},
            {"form": "overlapped", "short_step_ms": 0, "threads": 2, "strict": True},
            {"balance": "paper", "batch_pairs": 7, "queue_capacity": 3, "threads": 2},
            {"stay_awake": 100, "threads": 2},
        ):
            self.assertEqual(hashes(tandem.builtin_scene("cubes-on-plane", 80), 6, **options), expected, options)
        scene, pipeline = tandem.builtin_scene("cubes-on-plane", 80), tandem.Pipeline(
            form="ordered", short_step_ms=0, threads=2
        )
        report = pipeline.step(scene)
        self.assertEqual(report.form, "ordered")
        self.assertGreater(report.busy_ms, 0)
        self.assertTrue(report.broad_phase_reason)
        for bad, message in [
            ({"form": "fast"}, "form.*ordered"),
            ({"balance": "no"}, "balance.*paper"),
            ({"stay_awake": -1}, "stay_awake"),
            ({"batch_pairs": 0}, "pairs"),
        ]:
            with self.assertRaisesRegex(ValueError, message):
                tandem.Pipeline(**bad)

    def test_memory(self):
        scene, pipeline = tandem.builtin_scene("cubes-on-plane", 80), tandem.Pipeline()
        pipeline.step(scene)
        for held in (scene, pipeline):
            self.assertEqual(sum(held.memory_by_part.values()), held.memory)
            self.assertGreater(held.memory_by_part["bodies"], 80 * 24)

    def test_lists_of_a_scene(self):
        scene = tandem.Scene()
        shape = scene.add_shape(tandem.Sphere(0.1))
        ground = scene.add_body(tandem.HalfSpace([0, 0, 1]), is_static=True, group=2, mask=5)
        ball = scene.add_body(shape, velocity=[1, 2, 3], angular_velocity=[4, 5, 6], density=7, is_sensor=True, continuous=True)
        self.assertEqual(scene.velocities().tolist(), [[0, 0, 0], [1, 2, 3]])
        self.assertEqual(scene.angular_velocities().tolist(), [[0, 0, 0], [4, 5, 6]])
        self.assertEqual(scene.densities()[1], 7)
        self.assertEqual((scene.groups().tolist(), scene.masks().tolist()), ([2, 1], [5, 2**32 - 1]))
        self.assertEqual(scene.is_static().tolist(), [True, False])
        self.assertEqual(scene.is_sensor().tolist(), [False, True])
        self.assertEqual(scene.continuous().tolist(), [False, True])
        self.assertEqual(scene.shape_id(ball), shape)
        scene.replace_shape(shape, tandem.Box([1, 1, 1]))
        self.assertEqual(scene.shape_of(ball).kind, "box")
        with self.assertRaisesRegex(ValueError, "half-?space|static"):
            scene.replace_shape(shape, tandem.HalfSpace([0, 0, 1]))
        self.assertEqual(scene.shape_of(ground).kind, "halfspace")

    def test_contacts_are_those_of_the_pairs(self):
        scene = tandem.builtin_scene("cubes-on-plane", 150)
        pipeline = tandem.Pipeline(margin=tandem.recommended_margin(scene))
        response = tandem.Response()
        for _ in range(30):
            pipeline.step(scene)
            response.step(scene, pipeline)
        report = pipeline.step(scene)
        contacts, pairs = pipeline.contacts(), pipeline.pairs()
        self.assertEqual(len(contacts), report.contacts + report.gaps)
        self.assertEqual(pairs["contact_count"].sum(), len(contacts))
        self.assertGreater(len(contacts), 100)
        self.assertTrue((contacts["a"] < contacts["b"]).all())
        np.testing.assert_allclose(np.linalg.norm(contacts["normal"], axis=1), 1, atol=1e-12)
        self.assertTrue(contacts.flags.owndata)
        ids = scene.ids()
        pair = pairs[pairs["collide"]][0]
        a, b = int(ids[pair["a"]]), int(ids[pair["b"]])
        alone = tandem.contacts(
            scene.shape_of(a), scene.pose(a), scene.shape_of(b), scene.pose(b), margin=tandem.recommended_margin(scene)
        )
        mine = contacts[pair["first_contact"] : pair["first_contact"] + pair["contact_count"]]
        np.testing.assert_array_equal(mine["point"], alone["point"])
        np.testing.assert_array_equal(mine["depth"], alone["depth"])

    def test_events_name_bodies(self):
        scene, pipeline, events = tandem.Scene(), tandem.Pipeline(threads=1), tandem.ContactEvents()
        a = scene.add_body(tandem.Sphere(1))
        b = scene.add_body(tandem.Sphere(1), [1.5, 0, 0, 1, 0, 0, 0])
        pipeline.step(scene)
        events.update(scene, pipeline)
        self.assertEqual(events.began.tolist(), [[a, b]])
        scene.set_pose(b, [5, 0, 0, 1, 0, 0, 0])
        pipeline.step(scene)
        events.update(scene, pipeline)
        self.assertEqual(events.ended.tolist(), [[a, b]])
        self.assertEqual(events.began.shape, (0, 2))

    def test_scene_files_keep_contacts(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "scene.json"
            scene = tandem.builtin_scene("spheres-on-plane", 60)
            tandem.write_scene(path, scene)
            self.assertEqual(hashes(tandem.read_scene(str(path)), 5), hashes(scene, 5))
            path.write_text('{"version": ')
            with self.assertRaisesRegex(ValueError, "scene.json"):
                tandem.read_scene(path)

    def test_bodies_that_come_and_go(self):
        scene = tandem.Scene()
        scene.name, scene.gravity, scene.dt = "mine", [0, 0, -1], 0.01
        self.assertEqual((scene.name, scene.gravity.tolist(), scene.dt), ("mine", [0, 0, -1], 0.01))
        at = np.tile(np.eye(4), (5, 1, 1))
        at[:, 0, 3] = np.arange(5)
        ids = scene.add_bodies(tandem.Sphere(0.4), at)
        np.testing.assert_array_equal(scene.poses(), at)
        np.testing.assert_array_equal(scene.ids(), ids)
        scene.remove_body(int(ids[1]))
        self.assertEqual(len(scene), 4)
        self.assertEqual(scene.ids()[1], 0)
        with self.assertRaises(ValueError):
            scene.pose(int(ids[1]))
        seven = np.array([[9, 0, 0, 1, 0, 0, 0], [8, 0, 0, 0, 1, 0, 0]], float)
        scene.set_poses(ids[2:4], seven)
        np.testing.assert_array_equal(scene.pose(int(ids[3]))[:3, :3], np.diag([1, -1, -1]))
        kept = scene.copy()
        scene.remove_body(int(ids[0]))
        self.assertEqual((len(kept), len(scene)), (4, 3))

    def test_recordings_and_timelines(self):
        with tempfile.TemporaryDirectory() as folder:
            scene, pipeline = tandem.builtin_scene("cubes-on-plane", 20), tandem.Pipeline(threads=2)
            pipeline.record_timeline()
            record = pathlib.Path(folder) / "steps.record"
            with tandem.Recording(record, scene) as recording:
                for _ in range(3):
                    pipeline.step(scene)
                    recording.add(scene, pipeline)
            trace = pathlib.Path(folder) / "trace.json"
            pipeline.write_timeline(trace)
            self.assertGreater(len(json.loads(trace.read_text())["traceEvents"]), 3)
            with self.assertRaisesRegex(ValueError, "closed"):
                recording.add(scene, pipeline)
            with self.assertRaisesRegex(ValueError, "nothing was recorded"):
                pipeline.write_timeline(trace)
            for what in (record, scene):
                page = tandem.show(what, path=pathlib.Path(folder) / "page.html")
                self.assertIn("<html", page.path.read_text()[:2000])
                self.assertIn("<iframe", page._repr_html_())
            (pathlib.Path(folder) / "no.record").write_text("x")
            with self.assertRaisesRegex(ValueError, "no.record"):
                tandem.show(pathlib.Path(folder) / "no.record")


if __name__ == "__main__":
    unittest.main()
