"""What tests/consumer/run.cmake asks of palpate.py: environment.py SCENE BAD_SCENE"""
import sys

import numpy as np

import palpate

scene, bad = sys.argv[1:3]
try:
    palpate.Model(bad)
    sys.exit("the bad scene was taken")
except palpate.Error as error:
    assert error.code == palpate.BAD_INPUT and str(error).startswith("bad.toml:") and "poisson" in str(error), error

model = palpate.Model(scene)
environment = palpate.Environment(model, ticks=5, seconds=0.2, scatter=0.002)


def refused(kind, call, text):
    try:
        call()
    except kind as error:
        assert text in str(error), error
    else:
        sys.exit(f"not refused: {text}")


refused(palpate.Error, lambda: environment.step(model.tool_start), "reset() the environment")
refused(TypeError, lambda: palpate.Simulation(scene), "made of a Model")
refused(ValueError, lambda: palpate.Model("block\0.toml"), "zero byte")
refused(TypeError, lambda: environment.simulation.step(ticks=1.5), "float")
refused(palpate.Error, lambda: environment.simulation.step(ticks=-1), "step: ")


def episode(seed):
    first, info = environment.reset(seed=seed)
    assert info["state"].force.tolist() == [0, 0, 0]
    rows, truncated = [first], False
    target = environment.start[:3].copy()
    while not truncated:
        target[2] = max(target[2] - 0.002, environment.start[2] - model.first_contact_travel - 0.001)
        row, reward, terminated, truncated, info = environment.step(target)
        assert reward == 0 and not terminated
        rows.append(row)
    return np.array(rows), info["state"], environment.simulation.hash()


rows, state, hash_value = episode(7)
again, _, hash_again = episode(7)
other, _, _ = episode(8)
assert np.array_equal(rows, again) and hash_value == hash_again, "equal seeds gave other numbers"
assert not np.array_equal(rows, other), "the seed changed nothing"
assert rows.shape == (20, 17) and rows[-1, 9] > 0, rows[-1]

simulation = environment.simulation
vertex, force = simulation.contacts()
assert np.allclose(force.sum(axis=0), -simulation.read().force, atol=1e-4 * np.linalg.norm(simulation.read().force))
assert simulation.skin_positions().shape == (model.skin_vertex_count, 3) and vertex.max() < model.skin_vertex_count
assert model.triangles.max() == model.skin_vertex_count - 1
tool = simulation.read_tool()
assert model.tool_count == 1 and np.array_equal(tool.force, simulation.read().force) and tool.pinch == 0
saved = simulation.save()
a = simulation.step(ticks=10).force
simulation.restore(saved)
assert np.array_equal(a, simulation.step(ticks=10).force)
try:
    simulation.set_material(0, yuong=1000.0)
    sys.exit("a parameter that is none was taken")
except palpate.Error as error:
    assert error.code == palpate.BAD_ARGUMENT and "young" in str(error), error
try:
    picture = environment.render(80, 60)
    assert picture.shape == (60, 80, 4) and picture[..., :3].std() > 1 and (picture[..., 3] == 255).all()
except palpate.Error as error:
    assert "PALPATE_APP" in str(error) or "EGL" in str(error), error
