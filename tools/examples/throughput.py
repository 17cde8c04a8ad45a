#!/usr/bin/python3
"""Ticks a second of many simulations on one thread and on several, taken in turn: throughput.py [SCENE] [N] [THREADS]

Needs PYTHONPATH=<palpate>/share/palpate/python, or tools/python of the source tree.
"""
import statistics
import sys
import time

import numpy as np

import palpate

scene = sys.argv[1] if len(sys.argv) > 1 else "layer_sphere"
count = int(sys.argv[2]) if len(sys.argv) > 2 else 64
threads = int(sys.argv[3]) if len(sys.argv) > 3 else 2
model = palpate.Model(scene, threads=1)
simulations = [palpate.Simulation(model) for _ in range(count)]
poses = np.array([model.pose_at(0.001 + 0.0001 * k / count) for k in range(count)])
palpate.step_many(simulations, poses, 200)  # pressed in
rounds, ticks = 15, 5
ratios, rates = [], {1: [], threads: []}
teams = {n: palpate.Team(n) for n in rates}
for _ in range(rounds):
    for n, team in teams.items():
        begin = time.perf_counter()
        palpate.step_many(simulations, poses, ticks, team)
        rates[n].append(count * ticks / (time.perf_counter() - begin))
    ratios.append(rates[threads][-1] / rates[1][-1])
for n, rate in rates.items():
    print(f"{n} threads: {statistics.median(rate):.0f} ticks/s, at best {max(rate):.0f}")
print(f"{scene}, {count} simulations: {statistics.median(ratios):.2f} times as many, "
      f"best against best {max(rates[threads]) / max(rates[1]):.2f}")
