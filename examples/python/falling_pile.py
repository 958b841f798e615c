"""A pile falls on a plane, and a page shows how it fell."""

import sys

import numpy as np
import tandem

scene = tandem.Scene()
scene.add_body(tandem.HalfSpace([0, 0, 1]), is_static=True)
places = np.tile([0.0, 0, 0, 1, 0, 0, 0], (200, 1))
places[:, :3] = np.random.default_rng(1).uniform([-1, -1, 0.5], [1, 1, 8], (200, 3))
scene.add_bodies(tandem.Capsule(0.1, 0.3), places[:100])
scene.add_bodies(tandem.Box([0.3, 0.3, 0.3]), places[100:])

pipeline, response = tandem.Pipeline(margin=tandem.recommended_margin(scene)), tandem.Response()
with tandem.Recording("pile.record", scene) as recording:
    for _ in range(240):
        report = pipeline.step(scene)
        recording.add(scene, pipeline)
        response.step(scene, pipeline)
print(f"{report.contacts} contacts of {report.bodies} bodies, none deeper than {report.max_depth:.1e} m")
if "--no-page" not in sys.argv:
    print(tandem.show("pile.record", path="pile.html"))
