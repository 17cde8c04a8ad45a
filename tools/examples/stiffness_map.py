#!/usr/bin/python3
"""A map of stiffness from presses: stiffness_map.py [SEEDS] [MTLED]

A slab of 20 regions, 10 x 8 x 3 cm, is pressed at 40 places until it is at rest; the forces get noise of 1 % of the
mean one, and `mtled identify --regions` finds the regions' moduli again. Prints how many of its 95 % intervals hold the
truth. Needs PYTHONPATH=<palpate>/share/palpate/python, or tools/python of the source tree.
"""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

import palpate

seeds = max(1, int(sys.argv[1])) if len(sys.argv) > 1 else 1
mtled = sys.argv[2] if len(sys.argv) > 2 else "mtled"
columns, rows, size, depth = 5, 4, np.array([0.10, 0.08, 0.03]), 0.003
tissue = 'model = "neo-hookean"\nyoung = {young}\npoisson = 0.45\n'
names = [f"region {k + 1}" for k in range(columns * rows)]
low = -size[:2] / 2


def scene(moduli):
    text = f"""name = "stiffness map"
[organ]
solid = "box"
size = {size.tolist()}
[discretization]
spacing = 0.009
[[fixed]]
name = "base"
shape = "near-plane"
point = [0, 0, 0]
normal = [0, 0, 1]
distance = 1e-6
[tool]
shape = "sphere"
radius = 0.012
position = [0, 0, 0.05]
friction = 0
"""
    for k, young in enumerate(moduli):
        text += f'[[material]]\nname = "{names[k]}"\n' + tissue.format(young=young)
        if k > 0:
            corner = low + size[:2] / (columns, rows) * (k % columns, k // columns)
            other = corner + size[:2] / (columns, rows)
            text += (f'region = {{ shape = "box", min = [{corner[0]}, {corner[1]}, -1], '
                     f'max = [{other[0]}, {other[1]}, 1] }}\n')
    return text


truth = 3000 * np.exp(np.random.default_rng(20).normal(0, 0.4, len(names)))
places = np.array([(x, y) for x in np.linspace(-0.042, 0.042, 8) for y in np.linspace(-0.03, 0.03, 5)])
tips = np.column_stack([places, np.full(len(places), size[2] - depth)])
model = palpate.Model(text=scene(truth))
forces = []
for tip in tips:
    pose = model.tool_start.copy()
    pose[:3] = tip
    at_rest = palpate.Equilibrium(model, pose)
    forces.append(at_rest.force(-model.tool_axis))
    at_rest.close()
forces = np.array(forces)
noise = 0.01 * forces.mean()
print(f"{model.node_count} nodes, {len(tips)} presses of {1e3 * depth:g} mm: {forces.min():.3f} .. "
      f"{forces.max():.3f} N, noise {noise:.4f} N; moduli {truth.min():.0f} .. {truth.max():.0f} Pa", flush=True)

held = np.zeros(len(names), dtype=int)
errors = []
with tempfile.TemporaryDirectory() as folder:
    file = os.path.join(folder, "map.toml")
    with open(file, "w") as out:
        out.write(scene(np.full(len(names), 3000.0)))
    for seed in range(seeds):
        measured = forces + np.random.default_rng(seed).normal(0, noise, len(forces))
        np.savetxt(os.path.join(folder, "presses.csv"), np.column_stack([tips, measured]), delimiter=",",
                   header="x_m,y_m,z_m,force_N", comments="")
        run = subprocess.run([mtled, "identify", file, "--regions", "--measured", os.path.join(folder, "presses.csv"),
                              "--out", folder], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        if run.returncode not in (0, 1, 3):
            sys.exit(run.stdout)
        with open(os.path.join(folder, "identify.json")) as found:
            report = json.load(found)
        regions = [report["regions"][name] for name in names]
        inside = np.array([r["noise_low_95"] <= t <= r["noise_high_95"] for r, t in zip(regions, truth)])
        held += inside
        errors.append([np.log(r["value"] / t) for r, t in zip(regions, truth)])
        width = np.median([np.log(r["noise_high_95"] / r["noise_low_95"]) / 2 for r in regions])
        print(f"seed {seed}: {inside.sum()} of {len(names)} intervals hold the truth, so far by region {held.min()} to "
              f"{held.max()} of {seed + 1}; error {np.std(errors[-1]):.3f}, half an interval {width:.3f}; "
              f"{report['maps_solved']} maps, {report['linear_solutions']} linear solutions", flush=True)
print(f"{100 * held.sum() / (seeds * len(names)):.1f} % of all intervals hold the truth")
