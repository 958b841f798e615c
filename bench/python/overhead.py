"""The cost of a call from Python beside the same in C++: single distances and batches of a planner, in turn in one process.
overhead.py [--rounds N]; PYTHONPATH has the module and cpp_loops (both in the build tree's python
folder; the latter after cmake --build build/release --target tandem_cpp_loops)."""

import argparse
import statistics
import time

import cpp_loops
import numpy as np
import tandem


def row(name, unit, cpp, python, answer):
    extra = [p - c for c, p in zip(cpp, python)]
    middle = statistics.median
    low, high = np.percentile(extra, [10, 90])
    print(
        f"{name:28} C++ {middle(cpp):9.3f} {unit}  Python {middle(python):9.3f} {unit}  "
        f"more {middle(extra):7.3f} ({low:.3f} to {high:.3f}) {unit}, {100 * middle(extra) / middle(cpp):5.1f} %  answer {answer}"
    )


def single(name, a, pose_a, b, pose_b, rounds, repeats=2000):
    cpp, python = [], []
    distance = tandem.distance
    for _ in range(rounds):
        mean, total = cpp_loops.distances(a, pose_a, b, pose_b, repeats)
        cpp.append(mean * 1e6)
        start = time.perf_counter()
        for _ in range(repeats):
            answer = distance(a, pose_a, b, pose_b)
        python.append((time.perf_counter() - start) / repeats * 1e6)
        assert abs(total / repeats - answer.signed_distance) < 1e-9
    row(name, "us", cpp, python, answer.signed_distance)


def batches(rounds):
    random = np.random.default_rng(1)
    scene = tandem.Scene()
    places = np.tile([0.0, 0, 0, 1, 0, 0, 0], (400, 1))
    places[:, :3] = random.uniform(-3, 3, (400, 3))
    scene.add_bodies(tandem.Box([0.3, 0.3, 0.3]), places)
    queries = tandem.SceneQueries(scene)
    links = [tandem.Capsule(0.06, 0.4)] * 7
    poses = np.tile(np.eye(4), (10_000, 7, 1, 1))
    poses[..., :3, 3] = random.uniform(-3, 3, (10_000, 1, 3)) + np.linspace(0, 0.5, 7)[:, None] * random.uniform(-1, 1, (10_000, 1, 3))
    cpp, python = [], []
    for _ in range(rounds):
        seconds, hits = cpp_loops.batch(scene, links, poses)
        cpp.append(seconds * 1e3)
        queries.check(links, poses)  # as in C++: the poses were read just before
        start = time.perf_counter()
        verdicts = queries.check(links, poses)
        python.append((time.perf_counter() - start) * 1e3)
        assert hits == (verdicts == 1).sum()
    row("10,000 of 7 links, 400 boxes", "ms", cpp, python, int(hits))


if __name__ == "__main__":
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--rounds", type=int, default=41)
    rounds = arguments.parse_args().rounds
    at = np.eye(4)
    at[0, 3] = 3
    single("two spheres", tandem.Sphere(1), np.eye(4), tandem.Sphere(1), at, rounds)
    single("two spheres, poses of 7", tandem.Sphere(1), [0.0, 0, 0, 1, 0, 0, 0], tandem.Sphere(1), [3.0, 0, 0, 1, 0, 0, 0], rounds)
    single("two boxes", tandem.Box([1, 1, 1]), np.eye(4), tandem.Box([1, 1, 1]), at, rounds)
    batches(rounds)
