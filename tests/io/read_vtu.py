"""Prints a VTU file, or the frames of a PVD file, as JSON; the VTU is read by meshio, which is independent of us.

Run by vtu_file_test.cpp with Debian's Python.
"""
import json
import sys
import xml.etree.ElementTree

path = sys.argv[1]
if path.endswith(".pvd"):
    root = xml.etree.ElementTree.parse(path).getroot()
    print(json.dumps([[float(d.get("timestep")), d.get("file")] for d in root.findall("Collection/DataSet")]))
    sys.exit()

try:
    import meshio
except ImportError as error:
    sys.exit(f"python3-meshio is missing ({error}): run tools/setup")

mesh = meshio.read(path)
result = {
    "points": mesh.points.tolist(),
    "cells": [[block.type, block.data.tolist()] for block in mesh.cells],
    "point_data": {name: [str(a.dtype), a.tolist()] for name, a in mesh.point_data.items()},
    "cell_data": {name: [str(a.dtype), a.tolist()] for name, (a,) in mesh.cell_data.items()},
}
print(json.dumps(result))
