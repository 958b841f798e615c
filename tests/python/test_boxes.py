"""Boxes alone: held against loops over all of them."""

import unittest

import numpy as np
import tandem


def some_boxes(count, seed=3):
    random = np.random.default_rng(seed)
    low = random.uniform(-5, 5, (count, 3)).astype(np.float32).astype(float)
    return np.stack([low, low + random.uniform(0, 1.5, (count, 3)).astype(np.float32)], 1).astype(np.float32).astype(float)


def overlap(a, b):
    return bool(np.all(a[0] <= b[1]) and np.all(b[0] <= a[1]))


class Boxes(unittest.TestCase):
    def test_pairs_by_every_method(self):
        boxes = some_boxes(150)
        expected = [[i, j] for i in range(150) for j in range(i + 1, 150) if overlap(boxes[i], boxes[j])]
        self.assertGreater(len(expected), 20)
        for method in ("brute", "sweep", "grid", "bvh", "auto"):
            self.assertEqual(tandem.overlapping_boxes(boxes, method=method).tolist(), expected, method)
        self.assertEqual(tandem.overlapping_boxes(np.zeros((0, 2, 3))).shape, (0, 2))

    def test_queries(self):
        boxes, asking = some_boxes(200), some_boxes(20, 4)
        queries = tandem.BoxQueries(boxes)
        items, begin = queries.overlapping(asking)
        for i, box in enumerate(asking):
            expected = [j for j in range(200) if overlap(box, boxes[j])]
            self.assertEqual(items[begin[i] : begin[i + 1]].tolist(), expected)
        hits, begin = queries.along([[-10, 0.1, 0.2]], [[2, 0, 0]])
        y_and_z = [0.1, 0.2]
        expected = [j for j in range(200) if np.all(boxes[j, 0, 1:] <= y_and_z) and np.all(boxes[j, 1, 1:] >= y_and_z)]
        self.assertGreater(len(expected), 0)
        self.assertEqual(sorted(hits["index"].tolist()), expected)
        np.testing.assert_allclose(hits["t"], (boxes[hits["index"], 0, 0] + 10) / 2)
        self.assertEqual(begin.tolist(), [0, len(expected)])
        self.assertEqual(len(queries.along([[-10, 0.1, 0.2]], [[2, 0, 0]], 1)[0]), 0)
        near, begin = queries.nearest([[0, 0, 0], [9, 9, 9]], 3)
        for i, point in enumerate(([0, 0, 0], [9, 9, 9])):
            distances = ((np.clip(point, boxes[:, 0], boxes[:, 1]) - point) ** 2).sum(1)
            found = near[begin[i] : begin[i + 1]]
            np.testing.assert_allclose(found["squared_distance"], np.sort(distances)[:3])
            np.testing.assert_allclose(distances[found["index"]], found["squared_distance"])
        self.assertGreater(queries.memory, 200 * 24)

    def test_refusals(self):
        good = some_boxes(3)
        for boxes, message in [
            (good[:, ::-1], r"boxes\[0\]: from .* on axis 0"),
            (good * np.nan, r"boxes\[0\]"),
            (good[:, 0], r"boxes: an array of shape \(3, 3\)"),
        ]:
            for call in (tandem.overlapping_boxes, tandem.BoxQueries, tandem.BoxQueries(good).overlapping):
                with self.assertRaisesRegex(ValueError, message):
                    call(boxes)
        with self.assertRaisesRegex(ValueError, "method.*bvh"):
            tandem.overlapping_boxes(good, method="fastest")
        with self.assertRaisesRegex(ValueError, "directions"):
            tandem.BoxQueries(good).along(np.zeros((2, 3)), np.ones((1, 3)))
        with self.assertRaisesRegex(ValueError, "direction"):
            tandem.BoxQueries(good).along(np.zeros((1, 3)), np.zeros((1, 3)))


if __name__ == "__main__":
    unittest.main()
