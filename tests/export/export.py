"""Exports a run and its replay with palpate, and opens them with assimp and meshio: export.py PALPATE READ_GLTF WORK

Exit code: 0; 77 where a reader is not installed; else what did not hold is printed.
"""
import csv
import json
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree

palpate, read_gltf, work = sys.argv[1:]
scenes = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../assets/scenes")
try:
    import meshio
    import numpy as np
except ImportError as error:
    print(f"not tried: {error}; tools/setup installs it")
    sys.exit(77)
if not os.path.exists(read_gltf):
    print("not tried: assimp is not installed (libassimp-dev); tools/setup installs it")
    sys.exit(77)
shutil.rmtree(work, ignore_errors=True)
os.makedirs(work)
os.chdir(work)


def run(*arguments, code=0, says="", scene="layer_sphere"):
    done = subprocess.run([palpate, scene, "--offscreen", "--fast", "--size", "320x240", *arguments],
                          capture_output=True, text=True)
    assert done.returncode == code and says in done.stdout + done.stderr, (arguments, done)


run("--seconds", "0.52", "--record", "run.rec", "--export", "live.glb", "--out", "live")
run("--replay", "run.rec", "--export", "run.gltf", "--out", "replay")
run("--replay", "run.rec", "--export", "run.pvd", "--out", "series")
read = [json.loads(subprocess.run([read_gltf, file], capture_output=True, text=True, check=True).stdout)
        for file in ("live.glb", "run.gltf")]
assert read[0] == read[1], "the replay looks otherwise"
read = read[0]
rows = list(csv.DictReader(open("replay/force.csv")))
forces = {round(float(row["time_s"]), 6): row for row in rows}
times = [round(key["time"], 6) for key in read["morphs"]]
assert times == [0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.52], times

# The tool is where force.csv has it, and the skin's lowest vertex beneath it where the tip has pressed it.
tissue = read["meshes"][0]
rest, targets = np.array(tissue["vertices"]), np.array(tissue["targets"])
tips = np.array([key["position"] for key in read["motion"]])
for k, time in enumerate(times[1:], 1):
    place = [float(forces[time][f"tool_{axis}_m"]) for axis in "xyz"]
    assert np.allclose(tips[k], place, atol=1e-6), (time, tips[k], place)
pressed = (rest - targets[-1])[:, 2].max()
depth = rest[:, 2].max() - tips[-1][2]
assert depth > 1e-3 and abs(pressed - depth) < 0.1 * depth, (pressed, depth)
assert np.abs(targets[0] - rest).max() == 0

# Forces of each tool and of each rigid body, and who is who: jaws, a second tool, a table.
jaws = open(os.path.join(scenes, "strip_grasp.toml")).read().replace("script:motions", f"script:{scenes}/motions")
open("jaws.toml", "w").write(jaws + """
[[tool]]
shape = "sphere"
radius = 0.004
position = [0, 0.01, 0.03]
direction = [0, 0, -1]
[[rigid]]
name = "shelf"
region = { shape = "box", min = [0.045, -0.005, -0.005], max = [0.055, 0.005, 0.005] }
""")
run("--seconds", "0.8", "--export", "jaws.gltf", "--out", "jaws", scene="jaws.toml")
file = json.load(open("jaws.gltf"))
names = [node["name"] for node in file["nodes"] if "mesh" in node]
assert names[1:] == ["tool 1, left finger", "tool 1, right finger", "tool 2", "table", "shelf"], names
curves = file["scenes"][0]["extras"]
last = list(csv.DictReader(open("jaws/force.csv")))[-1]
for curve, column in (("force_N_z", "force_raw_N_z"), ("tool2_force_N_z", "tool2_force_N_z")):
    assert np.isclose(curves[curve][-1], float(last[column]), atol=1e-6), (curve, curves[curve][-1], last[column])
assert abs(curves["force_N_z"][-1]) > 1e-3 and abs(curves["table_force_N_z"][-1]) > 1e-2
assert curves["shelf_force_N_x"][-1] == 0

# The series has the same moments but rest, and the same press, at its nodes.
series = xml.etree.ElementTree.parse("run.pvd").getroot().findall("Collection/DataSet")
assert [round(float(part.get("timestep")), 6) for part in series] == times[1:]
body = meshio.read(series[-1].get("file"))
assert {"J", "von_Mises_Pa", "pressure_Pa"} <= set(body.cell_data)
assert abs(-body.point_data["displacement_m"][:, 2].min() - pressed) < 0.2 * pressed

# What is refused is told before a run, and leaves no file.
run("--export", "run.vtk", code=2, says=".pvd")
run("--export", "none/run.glb", code=1, says="none/run.glb")
run("--export", "long.glb", "--seconds", "61", code=2, says="--seconds")
run("--export", "two.glb", "--seconds", "1", "--snapshot-at", "0.5", code=2, says="--snapshot-at")
kept = ["jaws", "jaws.gltf", "jaws.toml", "live", "live.glb", "out", "replay", "run", "run.gltf", "run.pvd", "run.rec", "series"]
assert sorted(os.listdir()) == kept, os.listdir()
print("all held")
