"""A planner asks for ten thousand configurations of a three-link arm among pillars at once."""

import numpy as np
import tandem

rng = np.random.default_rng(1)
scene = tandem.Scene()
pillars = np.tile([0.0, 0, 0, 1, 0, 0, 0], (60, 1))
pillars[:, :2] = rng.uniform(-3, 3, (60, 2))
pillars = pillars[np.hypot(pillars[:, 0], pillars[:, 1]) > 0.6]
scene.add_bodies(tandem.Cylinder(0.1, 2), pillars)
queries = tandem.SceneQueries(scene)

# Links are capsules of a metre along z; joints turn about z, so that the arm lies in the plane z = 0.
links = [tandem.Capsule(0.05, 1.0)] * 3
angles = rng.uniform(-np.pi, np.pi, (10_000, 3)).cumsum(axis=1)
along = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)
poses = np.zeros((10_000, 3, 4, 4))
poses[..., :3, 2] = along
poses[..., 2, 0] = 1
poses[..., :3, 1] = np.cross(along, [0, 0, 1])
poses[..., :3, 3] = along.cumsum(axis=1) - along / 2
poses[..., 3, 3] = 1

of_links = np.zeros((3, 3), bool)
of_links[0, 2] = True  # neighbours touch at their joint
verdicts = queries.check(links, poses, self_pairs=of_links)
free = verdicts == 0
print(f"{free.sum()} of {len(verdicts)} configurations are free")
clear = queries.clearance(links, poses[free], self_pairs=of_links, cutoff=1.0)
print(f"the freest keeps {clear.max():.3f} m away from everything")
if (clear <= 0).any():
    raise SystemExit("WRONG: a free configuration without clearance")
