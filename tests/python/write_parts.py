"""Three cubes as binary STL files, of which two intersect: write_parts.py FOLDER"""

import pathlib
import struct
import sys

from test_collision_manager import cube

folder = pathlib.Path(sys.argv[1])
folder.mkdir(exist_ok=True)
for name, x, y in (("left", 0, 0), ("middle", 0.9, 0.1), ("right", 2.5, 0)):
    part = cube()
    corners = (part.vertices + [x, y, 0])[part.faces].reshape(-1, 9)
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle, 0) for triangle in corners)
    (folder / f"{name}.stl").write_bytes(bytes(80) + struct.pack("<I", len(corners)) + records)
