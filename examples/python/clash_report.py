"""Which parts of a folder of STL files, all in one frame, intersect? A table, and a page that shows them:
clash_report.py FOLDER [PAGE.html]"""

import pathlib
import sys

import tandem

folder = pathlib.Path(sys.argv[1])
scene, names = tandem.Scene(), {}
for file in sorted(folder.glob("*.stl")):
    names[scene.index(scene.add_body(tandem.read_mesh(file)))] = file.stem

pipeline = tandem.Pipeline()
report = pipeline.step(scene)
print(f"{report.colliding_pairs} clashes of {len(names)} parts")
for pair in pipeline.pairs():
    if pair["collide"]:
        contacts = pipeline.contacts()[pair["first_contact"] : pair["first_contact"] + pair["contact_count"]]
        deepest = contacts[contacts["depth"].argmax()]
        print(
            f"{names[pair['a']]:20} {names[pair['b']]:20} {deepest['depth']:10.4g} m deep at {deepest['point'].round(4)}"
        )
if len(sys.argv) > 2:
    print(tandem.show(scene, pipeline, path=sys.argv[2]))
