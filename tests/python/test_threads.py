"""Python's threads at once: answers stay the same, other threads run meanwhile, nothing hangs."""

import sys
import threading
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import tandem


class Threads(unittest.TestCase):
    def test_queries_and_changes_at_once(self):
        scene = tandem.builtin_scene("cubes-on-plane", 100)
        queries = tandem.SceneQueries(scene)
        ball, where = tandem.Sphere(2), [[x * 0.3, 0, 1, 1, 0, 0, 0] for x in range(40)]
        expected = [queries.hits(ball, at).tolist() for at in where]
        with ThreadPoolExecutor(8) as pool:
            for _ in range(5):
                self.assertEqual(list(pool.map(lambda at: queries.hits(ball, at).tolist(), where)), expected)
            body = int(scene.ids()[-1])
            done = [pool.submit(scene.set_pose, body, [0, 0, 100 + i, 1, 0, 0, 0]) for i in range(50)]
            done += [pool.submit(queries.update, scene) for _ in range(50)]
            for each in done:
                each.result(timeout=60)

    def test_pipelines_of_several_threads(self):
        def steps(_):
            scene = tandem.builtin_scene("tori-on-plane", 20)
            pipeline, response = tandem.Pipeline(threads=2, contact_hash=True), tandem.Response(threads=2)
            hashes = []
            for _ in range(10):
                hashes.append(pipeline.step(scene).contact_hash)
                response.step(scene, pipeline)
            return hashes

        with ThreadPoolExecutor(4) as pool:
            all_hashes = list(pool.map(steps, range(8)))
        self.assertTrue(all(hashes == all_hashes[0] for hashes in all_hashes))

    def test_one_pipeline_shared(self):
        scene, pipeline = tandem.builtin_scene("cubes-on-plane", 50), tandem.Pipeline(threads=2, contact_hash=True)
        expected = pipeline.step(scene).contact_hash
        with ThreadPoolExecutor(4) as pool:
            reports = list(pool.map(lambda _: pipeline.step(scene).contact_hash, range(20)))
            lists = list(pool.map(lambda _: pipeline.contacts(), range(20)))
        self.assertEqual(set(reports), {expected})
        for contacts in lists:
            np.testing.assert_array_equal(contacts, lists[0])

    def test_other_threads_run_while_a_step_does(self):
        scene, pipeline = tandem.builtin_scene("tori-on-plane", 300), tandem.Pipeline(threads=1)
        rounds, ended, seen = [0], threading.Event(), []

        def steps():
            give_up = time.monotonic() + 60
            while not any(seen) and time.monotonic() < give_up:
                before = rounds[0]
                pipeline.step(scene)
                seen.append(rounds[0] > before)
            ended.set()

        interval = sys.getswitchinterval()
        sys.setswitchinterval(1000)  # s: threads change only where one gives the interpreter's lock away
        try:
            worker = threading.Thread(target=steps)
            worker.start()
            while not ended.is_set():
                rounds[0] += 1
                time.sleep(0)
            worker.join()
        finally:
            sys.setswitchinterval(interval)
        self.assertTrue(any(seen))


if __name__ == "__main__":
    unittest.main()
