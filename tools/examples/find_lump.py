"""Finds a hidden lump, and roughly how stiff it is, from presses: find_lump.py [X Y], its place in mm

Run top to bottom, or cell by cell (# %%) in an editor that knows notebooks. What is measured here comes from a
simulation whose lump the rest does not look at; with a robot and a phantom it is theirs.
"""
# %% A block of gel, and the lump in it.
import sys

import numpy as np

import palpate

SCENE = """[organ]
solid = "box"
size = [0.06, 0.06, 0.03]
[discretization]
spacing = 0.006
[[material]]
name = "gel"
model = "neo-hookean"
young = 3000
poisson = 0.45
[[material]]
name = "lump"
model = "neo-hookean"
young = {young}
poisson = 0.45
region = {{ shape = "sphere", centre = [{x}, {y}, 0.019], radius = 0.009 }}
[[fixed]]
shape = "near-plane"
point = [0, 0, 0]
normal = [0, 0, 1]
distance = 1e-6
[tool]
shape = "sphere"
radius = 0.006
position = [0, 0, 0.037]
"""
DEPTH, THERE, HELD = 0.003, 30, 170  # m; ticks to go above a place, and to press
GRID = np.array([(x, y) for x in np.linspace(-0.016, 0.016, 5) for y in np.linspace(-0.016, 0.016, 5)])
truth = np.array([float(a) / 1e3 for a in sys.argv[1:3]] or [0.008, -0.005])
true_young = 12000.0


def block(young, place):
    return palpate.Model(text=SCENE.format(young=young, x=place[0], y=place[1]), name="block")


def press(simulation, place):
    """The force, N, of a press from rest at a place of the top."""
    simulation.reset()
    down = simulation.model.pose_at(DEPTH)
    above = np.array(simulation.model.tool_start)
    down[:2] = above[:2] = place
    simulation.step(above, THERE)
    return simulation.step(down, HELD).force[2]


# %% A map of forces, measured with noise of 1 %, beside what most places have.
with palpate.Simulation(block(true_young, truth)) as phantom:
    measured = np.array([press(phantom, place) for place in GRID])
measured *= 1 + 0.01 * np.random.default_rng(1).normal(size=len(GRID))
excess = measured / np.median(measured) - 1
for row in excess.reshape(5, 5).T[::-1]:  # y up, x to the right
    print(" ".join(f"{100 * share:4.0f} %" for share in row))

# %% Where the force is too large the lump is: the middle of the places that are clearly so.
share = np.where(excess > 0.1 * excess.max(), excess, 0)
place = share @ GRID / share.sum()
print(f"the lump is at {1e3 * place[0]:.1f}, {1e3 * place[1]:.1f} mm; in truth at "
      f"{1e3 * truth[0]:.1f}, {1e3 * truth[1]:.1f} mm")

# %% How stiff it is: the force at the nearest press, by halving. The model is made for the stiffest that is tried.
nearest = int(np.argmin(np.linalg.norm(GRID - place, axis=1)))
soft, stiff = 3000.0, 48000.0
with palpate.Simulation(block(stiff, place)) as guess:
    for _ in range(7):
        young = np.sqrt(soft * stiff)
        guess.set_material("lump", young=young)
        force = press(guess, GRID[nearest])
        print(f"{young:6.0f} Pa: {100 * (force / measured[nearest] - 1):5.1f} % off")
        if force < measured[nearest]:
            soft = young
        else:
            stiff = young
young = np.sqrt(soft * stiff)
print(f"the lump has {young:.0f} Pa, in truth {true_young:.0f} Pa")

found = np.linalg.norm(place - truth) < 0.003 and 0.6 < young / true_young < 1.6
sys.exit(0 if found else 1)
