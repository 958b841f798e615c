"""Pair records as `tandem query` reads them, as shapes and poses of the module."""

import json
import os
import pathlib
import subprocess

import numpy as np
import tandem

PROGRAM = os.environ["TANDEM_PROGRAM"]
PAIRS = pathlib.Path(__file__).resolve().parent.parent / "narrowphase" / "pairs"


def records():
    for file in sorted(PAIRS.glob("*.jsonl")):
        for line in file.read_text(encoding="utf-8").splitlines():
            yield json.loads(line)


def query(lines):
    """What the program says of records."""
    text = "".join(json.dumps(line) + "\n" for line in lines)
    done = subprocess.run([PROGRAM, "query", "-"], input=text, capture_output=True, text=True, check=False)
    return [json.loads(line) for line in done.stdout.splitlines()]


def shape(record):
    kind = record["kind"]
    rounding = record.get("rounding", 0)
    if kind == "mesh":
        made = tandem.Mesh(
            np.array(record["vertices"]), np.array(record["triangles"]), solid=record.get("solid", False)
        )
    elif kind in ("convex", "triangle"):
        made = {"convex": tandem.Convex, "triangle": tandem.Triangle}[kind](np.array(record["vertices"]))
    elif kind == "halfspace":
        made = tandem.HalfSpace(record["normal"], record["offset"])
    elif kind == "plane":
        made = tandem.Plane(record["normal"], record["offset"])
    elif kind in ("capsule", "cylinder", "cone"):
        made = {"capsule": tandem.Capsule, "cylinder": tandem.Cylinder, "cone": tandem.Cone}[kind](
            record["radius"], record["length"]
        )
    elif kind == "sphere":
        made = tandem.Sphere(record["radius"])
    elif kind == "box":
        made = tandem.Box(record["size"])
    else:
        made = tandem.Ellipsoid(record["radii"])
    return made.rounded(rounding) if rounding else made


def pose(record):
    if "q" in record:
        return np.array(record["t"] + record["q"])
    matrix = np.eye(4)
    matrix[:3, :3] = record["R"]
    matrix[:3, 3] = record["t"]
    return matrix
