"""What tests/consumer/run.cmake asks of the Python package: environment.py SCENE BAD_SCENE"""
import copy
import os
import pickle
import sys
import tempfile

import numpy as np

import palpate

scene, bad = sys.argv[1:3]
try:
    palpate.Model(bad)
    sys.exit("the bad scene was taken")
except palpate.Error as error:
    assert error.code == palpate.BAD_INPUT and str(error).startswith("bad.toml:") and "poisson" in str(error), error

model = palpate.Model(scene)
environment = palpate.Environment(model, ticks=5, seconds=0.2, scatter=0.002, render_mode="rgb_array", size=(80, 60))


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
refused(TypeError, lambda: palpate.Model(), "of a scene or of a text")
refused(palpate.Error, lambda: palpate.Model(scene, set={"material[0].yuong": 1}), "yuong")
refused(palpate.Error, lambda: palpate.Model(text="nothing", name="mine"), "mine:1:")
refused(ValueError, lambda: environment.simulation.step([0, 0, np.nan, 0, 0, 0, 1]), "[2] is nan")
refused(ValueError, lambda: environment.simulation.step([0, 0, 0]), "(3,), not (7)")
refused(ValueError, lambda: palpate.Environment(model, render_mode="human"), "rgb_array")
for ticks in (0, -3):
    refused(ValueError, lambda: palpate.Environment(model, ticks=ticks), f"ticks is {ticks}")
refused(TypeError, lambda: palpate.Environment(model, ticks=1.5), "float")
refused(TypeError, lambda: palpate.Environment(model, tick=5), "tick")
refused(TypeError, lambda: palpate.VectorEnv(model, 2, rate_hz=1000), "rate_hz")
for seconds in (0, -1, np.nan):
    refused(ValueError, lambda: palpate.Environment(model, seconds=seconds), f"seconds is {seconds}")
refused(ValueError, lambda: palpate.Environment(model, scatter=np.nan), "scatter is nan")
refused(TypeError, lambda: palpate.Model(scene, set={"tool": {"radius": 0.01}}), "like \"tool.radius\"")
refused(TypeError, lambda: palpate.Model(scene, set={"tool.radius": None}), "NoneType")
for number in (np.nan, np.inf, -np.float32(np.inf)):
    refused(palpate.Error, lambda: palpate.Model(scene, set={"material[0].young": number}), "is not finite")


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
assert tool.expected_error == simulation.read().expected_error
saved = simulation.save()
a = simulation.step(ticks=10).force
simulation.restore(saved)
assert np.array_equal(a, simulation.step(ticks=10).force)
try:
    simulation.set_material(0, yuong=1000.0)
    sys.exit("a parameter that is none was taken")
except palpate.Error as error:
    assert error.code == palpate.BAD_ARGUMENT and "young" in str(error), error
refused(ValueError, lambda: simulation.set_material("lump", young=1), "no material 'lump'")
refused(palpate.Error, lambda: simulation.set_material(relaxation=[[0.3, 0.1]]), "gives the material no \"relaxation\"")
refused(palpate.Error, lambda: simulation.set_material(barrier_strength=1), "it has young, poisson, density, relax")
refused(palpate.Error, lambda: simulation.set_material(yöung=1), "no \"yöung\"")
try:
    picture = environment.render()
    assert picture.shape == (60, 80, 3) and picture.dtype == np.uint8 and picture.std() > 1
    assert palpate.image(simulation, 40, 30).shape == (30, 40, 4)
    turned = palpate.image(simulation, 40, 30, camera={"azimuth_deg": 90, "elevation_deg": 90})
    assert not np.array_equal(turned, palpate.image(simulation, 40, 30))
    refused(palpate.Error, lambda: palpate.image(simulation, camera={"elevation_deg": 91}), "its elevation -90 .. 90")
    refused(TypeError, lambda: palpate.image(simulation, camera={"fov": 30}), "no 'fov'")
except palpate.Error as error:
    assert "PALPATE_APP" in str(error) or "EGL" in str(error), error
assert palpate.Environment(model).render() is None

# A text, changes and names; what is pickled is the same again.
softer = palpate.Model(scene, set={"material[0].young": 2000.0, "organ.colour": [0.5, 0.4, 0.3]})
assert softer.hash != model.hash and model.materials == ["material 1"] and model.tools == ["sphere"]
again = pickle.loads(pickle.dumps(softer))
assert again.hash == softer.hash and copy.deepcopy(softer) is softer
BLOCK = """[organ]
solid = "box"
size = [0.06, 0.06, 0.03]
[discretization]
spacing = 0.012
[[material]]
name = "gel"
model = "neo-hookean"
young = 3000
poisson = 0.45
[[fixed]]
name = "base"
shape = "near-plane"
point = [0, 0, 0]
normal = [0, 0, 1]
distance = 1e-6
[tool]
shape = "sphere"
radius = 0.01
position = [0, 0, 0.035]
"""
block = palpate.Model(text=BLOCK, name="block")
assert (block.materials, block.regions) == (["gel"], ["base"])
assert pickle.loads(pickle.dumps(block)).hash == block.hash
relaxing = palpate.Simulation(palpate.Model(
    text=BLOCK.replace("poisson = 0.45", "poisson = 0.45\nrelaxation = [[0.3, 0.1], [0.2, 2.0]]")))
relaxing.set_material(relaxation=[[0.3, 0.1], [0.2, 0.5]])
now = relaxing.material("gel")
assert (now["poisson"], now["relaxation"]) == (0.45, [[0.3, 0.1], [0.2, 0.5]]), now
refused(palpate.Error, lambda: relaxing.set_material(relaxation=[[0.3, 0.1]]), "takes 4 values")
refused(ValueError, lambda: relaxing.set_material(relaxation=[[[0.3]]]), "a list of pairs")

# What a tick knows.
body = palpate.Simulation(block)
pressed = body.step(block.pose_at(0.003), ticks=200)
before = body.hash()
nodes, points = palpate.Points.nodes(block), palpate.Points.integration(block)
assert nodes.volume is None and np.isclose(points.volume.sum(), 0.06 * 0.06 * 0.03, rtol=0.01)
u = body.displacements(nodes)
assert u.shape == nodes.X.shape and np.abs(u).max() > 1e-3
out = np.empty_like(u)
assert body.displacements(nodes, out) is out and np.array_equal(out, u)
refused(ValueError, lambda: body.displacements(nodes, np.empty((3, 3))), "out must be")
assert np.allclose(body.displacements(palpate.Points(block, nodes.X)), u, atol=1e-9)
assert body.velocities(nodes).shape == u.shape
stress, J = body.stresses(points)
assert stress.shape == (block.point_count, 3, 3) and np.array_equal(stress, stress.transpose(0, 2, 1)) and J.min() > 0.5
force, moment = body.reactions()["base"]
assert np.linalg.norm(force - pressed.force) < 0.1 * np.linalg.norm(pressed.force), (force, pressed.force)
position, normal, on_tissue, tool = body.contact_points()
assert np.allclose(on_tissue.sum(axis=0), -pressed.force) and (np.einsum("ij,ij->i", normal, on_tissue) < 0).all()
assert body.ray(block.tool_start[:3] + [0, 0, 0.02], block.tool_axis).distance > 0.02
assert body.ray(block.tool_start[:3], -block.tool_axis) is None and body.closest([0, 0, 0.01]).distance < 0
refused(ValueError, lambda: palpate.Points(block, [[0, 0, 0.01], [0, np.inf, 0]]), "[1, 1] is inf")
refused(palpate.Error, lambda: palpate.Points(block, [[0, 0, 0.01], [0, 0, 0.1]]), "point 1 at")
refused(palpate.Error, lambda: body.displacements(palpate.Points.nodes(model)), "displacements: ")
assert body.hash() == before

# A spring at the skin, and a call after each tick.
ticks = []
body.on_tick(lambda state: ticks.append((state.tick, state.force[2])))
refused(palpate.Error, lambda: body.pull(block.skin_vertex_count, [0, 0, 0]), "pull: ")
refused(ValueError, lambda: body.pull(0, [0, 0, np.inf]), "[2] is inf")
body.pull(0, body.skin_positions()[0])
last = body.step(ticks=3)
body.release()
body.on_tick(lambda state: [][state.tick])
before = body.read().tick
refused(IndexError, lambda: body.step(ticks=2), "index")
assert body.read().tick == before + 2
body.on_tick(None)
try:
    body.on_tick(5)
    raise SystemExit("on_tick(5) was taken")
except TypeError as error:
    assert "call must be a function" in str(error), error
body.step()
assert [tick for tick, _ in ticks] == [201, 202, 203] and ticks[-1][1] == last.force[2]

# Loads.
loaded = palpate.Simulation(block)
at_rest = loaded.hash()
loaded.set_gravity([0, 0, -9.81])
loaded.set_force(5, [0, 0.01, 0])
assert loaded.hash() != at_rest and loaded.step(ticks=20).tick == 20 and loaded.reactions()["base"][0][2] > 0
loaded.reset()
loaded.set_gravity([0, 0, 0])
loaded.clear_forces()
assert loaded.hash() == at_rest
refused(ValueError, lambda: loaded.set_force(0, [0, 0, np.nan]), "[2] is nan")
refused(ValueError, lambda: loaded.set_force(-1, [0, 0, 1]), "no vertex -1")
refused(palpate.Error, lambda: loaded.set_force(1 << 20, [0, 0, 1]), "set_force: vertex is 1048576, not in -1 .. ")

# Pins, regions and a recording.
recorded = palpate.Simulation(block)
recorded.start_recording()
recorded.pin(5, recorded.skin_positions()[5] + [0, 0, 0.001])
recorded.move_region("base", [0, 0.0005, 0])
recorded.step(block.pose_at(0.001), ticks=30)
recorded.unpin()
before = recorded.hash()
refused(palpate.Error, lambda: recorded.stop_recording("/no/such/folder/run.rec"), "can't write")
refused(palpate.Error, lambda: recorded.restore(recorded.save()), "record_stop first")
refused(ValueError, lambda: recorded.pin(5, [0, np.nan, 0]), "[1] is nan")
refused(ValueError, lambda: recorded.move_region("lid", [0, 0, 0]), "no region 'lid'")
assert recorded.hash() == before
with tempfile.TemporaryDirectory() as folder:
    recorded.stop_recording(os.path.join(folder, "run.rec"))
    with open(os.path.join(folder, "run.rec")) as file:
        lines = file.read().splitlines()
assert lines[0] == "palpate-recording 3" and lines[-1] == "end 30", lines
assert [line.split()[1] for line in lines[4:-1]] == ["pin", "region", "tool", "unpin"], lines
refused(palpate.Error, recorded.start_recording, "reset first")
played = palpate.Simulation(model)  # for run.cmake, which replays it
played.start_recording()
top = played.skin_positions()[:, 2].argmax()
played.pin(top, played.skin_positions()[top] + [0, 0, 0.0005])
played.set_gravity([0, 0, -3])
played.step(model.pose_at(0.001), ticks=40)
played.move_region(0, [0.0003, 0, 0])
played.step(ticks=40)
played.stop_recording("python.rec")
print(f"{played.hash():016x}")

# Gradients.
two = palpate.Model(text=BLOCK + """friction = 0
[[material]]
name = "lump"
model = "neo-hookean"
young = 9000
poisson = 0.45
region = { shape = "sphere", centre = [0.01, 0, 0.017], radius = 0.01 }
""", name="two")
at_rest = palpate.Equilibrium(two, two.pose_at(0.002, (0.011, 0)))
up, numbers = [0, 0, 1], [("gel", "young"), ("lump", "young")]
lift = at_rest.force(up)
assert lift > 0.01 and np.isclose(at_rest.force(up, region="base"), lift, rtol=1e-6)
slopes = at_rest.sensitivity(numbers, up)
for (material, name), slope, young in zip(numbers, slopes, (3000.0, 9000.0)):
    values = []
    for changed in (young * 0.9999, young * 1.0001):
        at_rest.set(material, name, changed)
        values.append(at_rest.force(up))
    at_rest.set(material, name, young)
    assert abs((values[1] - values[0]) / 2e-4 - slope * young) < 1e-6 * abs(slopes @ [3000, 9000]), (values, slope)
seen = palpate.Points(two, [[0.011, 0, 0.028]])
assert at_rest.displacement(up, seen) < 0 < at_rest.sensitivity(numbers, up, points=seen)[1]
refused(palpate.Error, lambda: at_rest.sensitivity([("gel", "yuong")], up), "yuong")
refused(palpate.Error, lambda: at_rest.set("gel", "young", -1), "young")
refused(ValueError, lambda: at_rest.sensitivity([("jelly", "young")], up), "no material 'jelly'")
refused(palpate.Error, lambda: at_rest.displacement(up, palpate.Points.nodes(block)), "another model")
refused(palpate.Error, lambda: palpate.Equilibrium(two, threads=-1), "threads")
assert np.isclose(at_rest.force(up), lift, rtol=1e-9)
at_rest.close()
refused(palpate.Error, lambda: at_rest.force(up), "closed")

# A pickled simulation goes on bit for bit; what error is to be expected it finds anew.
twin = pickle.loads(pickle.dumps(body))
assert twin.hash() == body.hash() and np.array_equal(twin.step(ticks=7).force, body.step(ticks=7).force)
assert twin.hash() == body.hash()

# A device.
refused(TypeError, lambda: body.couple(stifness=1), "stifness")
refused(palpate.Error, lambda: body.couple(stiffness=1), "stiffness")
refused(ValueError, lambda: body.couple(locked=7), "locked is 7")
for sequence in (-1, 2 ** 32):
    refused(ValueError, lambda: body.exchange([0, 0, 0, 0, 0, 0, 1], sequence=sequence), f"sequence: {sequence} is not")
refused(palpate.Error, lambda: body.exchange([0, 0, 0, 0, 0, 0, 1]), "exchange: ")
body.couple(max_force=1)
wrench = body.exchange([0, 0, 0, 0, 0, 0, 1], sequence=3)
assert wrench.answers == 3 and wrench.force.shape == (3,) and body.coupling().poses == 1
try:
    body.exchange([np.nan] * 7)
    sys.exit("a pose that is none was taken")
except palpate.Error as error:
    assert error.wrench.sequence == 2
body.uncouple()

# Many at once: the bits of one after the other.
many, alone = ([palpate.Simulation(block) for _ in range(4)] for _ in range(2))
poses = np.array([block.pose_at(0.0005 * k) for k in range(4)])
team = palpate.Team(2)
states = palpate.step_many(many, poses, 100, team)
for k, simulation in enumerate(alone):
    state = simulation.step(poses[k], 100)
    assert np.array_equal(state.force, states["force"][k]) and simulation.hash() == many[k].hash()
hashes = [simulation.hash() for simulation in many]
poses[2, 1] = np.nan
refused(ValueError, lambda: palpate.step_many(many, poses, 1, team), "[2, 1] is nan")
refused(palpate.Error, lambda: palpate.step_many([many[0], many[1], many[0]], None, 1, team), "simulation 2: ")
many[3].close()
refused(palpate.Error, lambda: palpate.step_many(many, None, 1, team), "simulation 3: ")
assert [simulation.hash() for simulation in many[:3]] == hashes[:3]


# What gymnasium's checker asks of an environment.
def check_environment(env):
    assert env.metadata["render_modes"] == ["rgb_array"] and env.metadata["render_fps"] > 0
    assert env.unwrapped is env and env.render_mode is None
    env.action_space.seed(5)
    action = env.action_space.sample()
    assert action in env.action_space and np.isfinite(env.action_space.low).all()
    outcomes = []
    for seed in (123, 123, 456):
        observation, info = env.reset(seed=seed)
        assert observation in env.observation_space and isinstance(info, dict)
        random_state = env.np_random.bit_generator.state
        outcomes.append((observation, random_state, *env.step(action)))
        assert outcomes[-1][2] in env.observation_space
        reward, terminated, truncated, info = outcomes[-1][3:]
        assert type(reward) is float and type(terminated) is bool and type(truncated) is bool
    a, b, c = outcomes
    assert np.array_equal(a[0], b[0]) and a[1] == b[1] and np.array_equal(a[2], b[2]) and a[6] == b[6]
    assert a[1] != c[1] and not np.array_equal(a[0], c[0])
    assert env.np_random_seed == 456
    env.reset()  # goes on with the numbers of that seed
    assert env.np_random_seed == 456 and env.np_random.bit_generator.state != random_state
    for space, one in ((env.action_space, action), (env.observation_space, observation)):
        assert space.shape == one.shape and space.dtype == one.dtype and (space.low < space.high).all()
        assert space.sample() in space
        space.seed(9)
        first = space.sample()
        space.seed(9)
        assert np.array_equal(first, space.sample())
    assert env.action_space.low - 1 not in env.action_space and env.observation_space.sample()[:-1] not in \
        env.observation_space
    for steps in range(1, 100):
        observation, _, terminated, truncated, info = env.step(action)
        assert observation in env.observation_space and "state" in info and not terminated
        if truncated:
            break
    assert steps == 4, steps  # of 4 ticks of 2 ms in 0.04 s, less that of reset()
    assert np.array_equal(env.reset(options={})[0].shape, (17,))


with palpate.Environment(block, ticks=4, seconds=0.04, scatter=0.002) as checked:
    check_environment(checked)
    before = checked.simulation.hash()
    refused(ValueError, lambda: checked.step([0, np.nan, 0]), "[1] is nan")
    refused(ValueError, lambda: checked.step([0, 0]), "(1, 3)")
    refused(ValueError, lambda: checked.step([0, 0, 0.1, 0, 0, 0, 0]), "is no turn")
    assert checked.simulation.hash() == before
    held = copy.deepcopy(checked)
    assert np.array_equal(held.step(checked.start)[0], checked.step(checked.start)[0])
checked.close()
refused(palpate.Error, lambda: checked.step(checked.start), "closed")

# Many environments are as many single ones, those that begin anew included.
vector = palpate.VectorEnv(block, 3, threads=2, ticks=4, seconds=0.04, scatter=0.002)
single = [palpate.Environment(block, ticks=4, seconds=0.04, scatter=0.002) for _ in range(3)]
observations, info = vector.reset(seed=11)
assert np.array_equal(observations, [env.reset(seed=11 + k)[0] for k, env in enumerate(single)])
assert observations in vector.observation_space and vector.action_space.shape == (3, 3)
ended = [False] * 3
for step in range(8):
    actions = np.array([env.start[:3] - [0, 0, 0.002 * step + 0.0005 * k] for k, env in enumerate(single)])
    observations, rewards, terminated, truncated, info = vector.step(actions)
    for k, env in enumerate(single):
        expected = (env.reset()[0], 0.0, False, False) if ended[k] else env.step(actions[k])[:4]
        assert np.array_equal(observations[k], expected[0]) and truncated[k] == expected[3], (step, k)
        ended[k] = expected[3]
    assert info["state"]["force"].shape == (3, 3) and rewards.shape == terminated.shape == (3,)
assert any(ended) or step == 7
actions[1, 2] = np.inf
refused(ValueError, lambda: vector.step(actions), "action 1: [2] is inf")
refused(ValueError, lambda: vector.step(actions[:2]), "3 actions")
refused(ValueError, lambda: vector.reset(seed=[1, 2]), "2 seeds for 3")


class Steps(palpate.Environment):  # relative ways down, pictures to look at, an end of its own
    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.observation_space = palpate.environment.Box(0, 1, (2, 3), dtype=np.float32)

    def pose(self, action):
        return self.simulation.read().pose[:3] + [0, 0, -float(action[0])]

    def observe(self, state):
        return np.full((2, 3), min(1, state.depth > 0), np.float32)

    def terminated(self, state):
        return state.time > 0.025


steps = palpate.VectorEnv(block, 2, ticks=4, environment=Steps)
assert steps.reset(seed=3)[0] in steps.observation_space and steps.observation_space.shape == (2, 2, 3)
alone = Steps(block, ticks=4)
alone.reset(seed=3)
down = np.array([[0.0005], [0.001]])
for step in range(3):
    _, _, terminated, _, info = steps.step(down)
    last = alone.step(down[0])
    assert np.array_equal(info["state"]["pose"][0], last[4]["state"].pose) and terminated[0] == last[2] == (step == 2)
steps.step(down)  # both have ended, and begin anew
steps.envs[1].terminated = lambda state: False
for step in range(4):  # one ends, the other goes on
    steps.step(down)
steps.close()
alone.close()
Steps.step = lambda self, action: None
refused(TypeError, lambda: palpate.VectorEnv(block, 2, environment=Steps), "does not call Steps.step")
error = pickle.loads(pickle.dumps(palpate.Error(3, "no")))
assert (error.code, str(error)) == (3, "no")
twins = pickle.loads(pickle.dumps(vector))
actions[1, 2] = 0.05
assert np.array_equal(twins.step(actions)[0], vector.step(actions)[0])
vector.close()
vector.close()
refused(palpate.Error, lambda: vector.step(actions), "closed")
