"""Queries and batches say what single pairs say."""

import unittest

import numpy as np
import tandem


def world(seed=2, bodies=40):
    random = np.random.default_rng(seed)
    scene = tandem.Scene()
    at = np.tile([0.0, 0, 0, 1, 0, 0, 0], (bodies, 1))
    at[:, :3] = random.uniform(-3, 3, (bodies, 3))
    return scene, scene.add_bodies(tandem.Box([0.5, 0.6, 0.7]), at), at


class Queries(unittest.TestCase):
    def setUp(self):
        self.scene, self.ids, self.at = world()
        self.box, self.ball = tandem.Box([0.5, 0.6, 0.7]), tandem.Sphere(1.2)
        self.queries = tandem.SceneQueries(self.scene)
        self.distances = np.array([tandem.distance(self.box, at, self.ball, None).signed_distance for at in self.at])

    def test_one_shape(self):
        touched = [int(i) for i, d in zip(self.ids, self.distances) if d <= 0]
        self.assertTrue(touched)
        self.assertTrue(self.queries.collides(self.ball))
        self.assertFalse(self.queries.collides(self.ball, [50, 0, 0, 1, 0, 0, 0]))
        self.assertFalse(self.queries.collides(self.ball, ignore=touched))
        self.assertEqual(self.queries.hits(self.ball).tolist(), touched)
        body, answer = self.queries.nearest(self.ball)
        self.assertEqual(body, int(self.ids[self.distances.argmin()]))
        self.assertAlmostEqual(answer.signed_distance, self.distances.min(), places=12)
        self.assertIsNone(self.queries.nearest(self.ball, [50, 0, 0, 1, 0, 0, 0], cutoff=1))
        near = self.queries.within(self.ball, margin=0.5)
        self.assertEqual([i for i, _ in near], [int(i) for i, d in zip(self.ids, self.distances) if d <= 0.5])
        self.assertEqual([i for i, _, _ in self.queries.contacts(self.ball)], touched)
        for _, answer, contacts in self.queries.contacts(self.ball):
            self.assertAlmostEqual(contacts["depth"].max(), -answer.signed_distance, places=9)

    def test_a_ray_meets_the_first_body(self):
        scene = tandem.Scene()
        for x in (3, 6):
            first = scene.add_body(tandem.Sphere(1), [x, 0, 0, 1, 0, 0, 0])
        body, touch = tandem.SceneQueries(scene).cast(tandem.Sphere(0), [10, 0, 0, 1, 0, 0, 0], None)
        self.assertEqual(body, first)
        self.assertAlmostEqual(touch.t, 0.3, places=12)

    def test_updates(self):
        where = [20, 0, 0, 1, 0, 0, 0]
        self.assertFalse(self.queries.collides(self.ball, where))
        self.scene.set_pose(int(self.ids[0]), where)
        self.assertFalse(self.queries.collides(self.ball, where))
        self.assertEqual(self.queries.update(self.scene), 1)
        self.assertTrue(self.queries.collides(self.ball, where))

    def test_batches_are_single_answers(self):
        random = np.random.default_rng(3)
        links = [tandem.Capsule(0.1, 0.4), tandem.Sphere(0.2)]
        at = np.tile(np.eye(4), (200, 2, 1, 1))
        at[:, :, :3, 3] = random.uniform(-3, 3, (200, 2, 3))
        inside = np.array([[False, True], [False, False]])
        verdicts = self.queries.check(links, at, self_pairs=inside)
        self.assertEqual((verdicts.dtype, verdicts.shape), (np.uint8, (200,)))
        alone = [
            any(self.queries.collides(link, pose) for link, pose in zip(links, poses))
            or tandem.collide(links[0], poses[0], links[1], poses[1])
            for poses in at
        ]
        self.assertEqual(verdicts.tolist(), [int(hit) for hit in alone])
        self.assertTrue(0 < verdicts.sum() < 200)
        clear = self.queries.clearance(links, at, cutoff=0.3)
        least = [
            min(
                min(
                    (self.queries.nearest(link, pose, cutoff=0.3) or (0, None))[1].signed_distance
                    if self.queries.nearest(link, pose, cutoff=0.3)
                    else 0.3
                    for link, pose in zip(links, poses)
                ),
                0.3,
            )
            for poses in at
        ]
        np.testing.assert_allclose(clear, least, atol=1e-12)
        quaternions = np.concatenate([at[:, :, :3, 3], np.tile([1.0, 0, 0, 0], (200, 2, 1))], axis=2)
        np.testing.assert_array_equal(self.queries.check(links, quaternions, self_pairs=inside), verdicts)
        nothing = self.queries.check(links, at, world_pairs=np.zeros((2, len(self.ids)), bool))
        self.assertEqual(nothing.sum(), 0)
        self.assertEqual(set(self.queries.check(links, at, timeout=0).tolist()) - {0, 1}, {2})

    def test_what_is_hit_first(self):
        links = [tandem.Capsule(0.1, 0.4), tandem.Sphere(0.2)]
        at = np.tile(np.eye(4), (300, 2, 1, 1))
        at[:, :, :3, 3] = np.random.default_rng(4).uniform(-3, 3, (300, 2, 3))
        both = np.array([[False, True], [False, False]])
        hits = self.queries.first_hits(links, at, self_pairs=both)
        np.testing.assert_array_equal(hits["verdict"], self.queries.check(links, at, self_pairs=both))
        self.assertTrue((hits["body"] != 0).any())
        for hit, poses in zip(hits, at):
            if hit["verdict"] == 0:
                continue
            if hit["body"] == 0:
                self.assertTrue(tandem.collide(links[0], poses[0], links[1], poses[1]))
            else:
                link = int(hit["link"])
                self.assertEqual(self.queries.hits(links[link], poses[link])[0], hit["body"])

    def test_asked_by_a_body(self):
        body, where = int(self.ids[3]), self.at[3]
        for mine, other in [
            (self.queries.collides_body(body, margin=0.4), self.queries.collides(self.box, where, margin=0.4, ignore=[body])),
            (self.queries.hits_body(body).tolist(), self.queries.hits(self.box, where, ignore=[body]).tolist()),
            (self.queries.nearest_body(body)[0], self.queries.nearest(self.box, where, ignore=[body])[0]),
            (
                [i for i, _ in self.queries.within_body(body, margin=1)],
                [i for i, _ in self.queries.within(self.box, where, margin=1, ignore=[body])],
            ),
        ]:
            self.assertEqual(mine, other)
        with self.assertRaisesRegex(ValueError, "body id"):
            self.queries.collides_body(12345)

    def test_progress(self):
        at = np.tile(np.eye(4), (4000, 1, 1, 1))
        told = []
        self.queries.check([self.ball], at, progress=lambda done, all: told.append((done, all)))
        self.assertIn((4000, 4000), told)

        def enough(done, all):
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            self.queries.clearance([self.ball], at, progress=enough)
        self.assertGreater(self.queries.memory, 40 * 24)

    def test_progress_that_updates_its_own_queries_is_refused(self):
        at = np.tile(np.eye(4), (4000, 1, 1, 1))
        others = tandem.SceneQueries(self.scene)
        told = []

        def updates(done, all):
            self.queries.update(self.scene)

        def asks_and_updates_others(done, all):
            told.append(self.queries.collides(self.ball))
            others.update(self.scene)

        def through_others(done, all):
            others.check([self.ball], at, progress=updates)

        for progress in (updates, through_others):
            with self.assertRaisesRegex(RuntimeError, "progress function cannot change"):
                self.queries.check([self.ball], at, progress=progress)
        self.queries.check([self.ball], at, progress=asks_and_updates_others)
        self.assertTrue(told and all(told))
        self.assertEqual(self.queries.update(self.scene), 0)

    def test_a_bad_pose_in_the_middle(self):
        at = np.tile(np.eye(4), (1000, 1, 1, 1))
        at[777, 0, 3, 3] = 2
        with self.assertRaisesRegex(ValueError, r"configuration 777, link 0: the last row of its matrix"):
            self.queries.check([self.ball], at)

    def test_motions(self):
        at = np.array([[[-50, 0, 0, 1, 0, 0, 0]], [[50, 0, 0, 1, 0, 0, 0]]], float)
        self.assertEqual(self.queries.check([self.ball], at, configurations_a_motion=2).tolist(), [0])
        self.assertEqual(self.queries.check([self.ball], at, configurations_a_motion=2, continuous=True).tolist(), [1])


if __name__ == "__main__":
    unittest.main()
