"""Simulations in the form that reinforcement learning is used to: gymnasium's; without it, one that behaves alike."""
import operator

import numpy as np

from ._library import BAD_ARGUMENT, REFUSED, Error, State, _State
from .model import Model
from .simulation import STATE, Simulation, Team, image, step_many

try:
    import gymnasium
    from gymnasium.spaces import Box

    Env, _VectorEnv = gymnasium.Env, gymnasium.vector.VectorEnv
    _autoreset = getattr(gymnasium.vector, "AutoresetMode", None)
except ImportError:
    gymnasium = _autoreset = None

    class Box:
        """Arrays between two bounds, as gymnasium.spaces.Box."""

        def __init__(self, low, high, shape=None, dtype=np.float32, seed=None):
            shape = np.shape(low) if shape is None else shape
            self.dtype, self.shape = np.dtype(dtype), tuple(shape)
            self.low = np.broadcast_to(np.asarray(low, dtype), shape).copy()
            self.high = np.broadcast_to(np.asarray(high, dtype), shape).copy()
            self.seed(seed)

        def seed(self, seed=None):
            self.np_random = np.random.default_rng(seed)

        def sample(self):
            """Even between finite bounds, else normally distributed."""
            bounded = np.isfinite(self.low) & np.isfinite(self.high)
            low, high = np.where(bounded, self.low, 0), np.where(bounded, self.high, 1)
            even, normal = self.np_random.uniform(low, high), self.np_random.normal(size=self.shape)
            return np.where(bounded, even, np.clip(normal, self.low, self.high)).astype(self.dtype)

        def contains(self, x):
            return (isinstance(x, np.ndarray) and np.can_cast(x.dtype, self.dtype) and x.shape == self.shape
                    and bool(np.all(x >= self.low) and np.all(x <= self.high)))

        __contains__ = contains

        def __eq__(self, other):
            return (isinstance(other, Box) and self.shape == other.shape and self.dtype == other.dtype
                    and np.array_equal(self.low, other.low) and np.array_equal(self.high, other.high))

        def __repr__(self):
            return f"Box({self.low.min()}, {self.high.max()}, {self.shape}, {self.dtype})"

    class _Seeded:
        spec, render_mode, _np_random, _np_random_seed = None, None, None, None

        def reset(self, *, seed=None, options=None):
            if seed is not None:
                self._seed(seed)

        def _seed(self, seed=None):
            sequence = np.random.SeedSequence(seed)
            self._np_random, self._np_random_seed = np.random.default_rng(sequence), sequence.entropy

        @property
        def np_random(self):
            if self._np_random is None:
                self._seed()
            return self._np_random

        @np_random.setter
        def np_random(self, generator):
            self._np_random, self._np_random_seed = generator, -1

        @property
        def np_random_seed(self):
            self.np_random
            return self._np_random_seed

        @property
        def unwrapped(self):
            return self

    class Env(_Seeded):
        def __enter__(self):
            return self

        def __exit__(self, *_):
            self.close()

    class _VectorEnv(_Seeded):
        closed = False

        def close(self, **arguments):
            if not self.closed:
                self.close_extras(**arguments)
            self.closed = True


def _poses(actions, fallback):
    """Poses (n, 7) of actions (n, 3) or (n, 7); a place keeps the turn of its fallback (n, 7). What is wrong is named
    by its index, before anything moves."""
    try:
        actions = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError) as reason:
        raise ValueError(f"an action that is no array of numbers: {reason}") from None
    if actions.shape not in ((len(fallback), 3), (len(fallback), 7)):
        raise ValueError(f"{len(fallback)} actions have the shape {(len(fallback), 3)}, places of the tip in m, or "
                         f"{(len(fallback), 7)}, poses; not {actions.shape}")
    poses = np.concatenate([actions[:, :3], actions[:, 3:] if actions.shape[1] == 7 else fallback[:, 3:]], axis=1)
    wrong = ~(np.abs(poses) <= 1e6)
    size = np.square(poses[:, 3:]).sum(axis=1)
    if wrong.any():
        k, c = np.argwhere(wrong)[0]
        raise ValueError(f"action {k}: [{c}] is {poses[k, c]}")
    if not np.all((size > 0.25) & (size < 4)):
        k = np.argmin((size > 0.25) & (size < 4))
        raise ValueError(f"action {k}: the quaternion {poses[k, 3:]} is no turn")
    return poses


def _batched(space, count):
    """The space of `count` of them, one row each."""
    if gymnasium is not None:
        return gymnasium.vector.utils.batch_space(space, count)
    low, high = (np.broadcast_to(bound, (count, *space.shape)) for bound in (space.low, space.high))
    return Box(low, high, dtype=space.dtype)


def _refuse(options):
    """Of a Model that was loaded before nothing can be set any more."""
    if options:
        raise TypeError(f"{', '.join(sorted(options))}: no argument of an environment of a Model that is loaded; "
                        "those of Model are given where it is")


class Environment(Env):
    """One simulation.

        observation, info = reset(seed=7)
        observation, reward, terminated, truncated, info = step(action)

    action       (3) where the tip should be, m, or (7) a pose: override pose(action) for others
    observation  (17) float64: pose of the tool (7), force (3), torque (3), normal (3), depth: override observe(state)
    reward       0: override reward(state)
    terminated   where the tissue is lost for good (State.frozen): override terminated(state)
    truncated    after `seconds` of physics time
    info         {"state": State}

    ticks: of physics in one step, at least 1. seconds: more than 0; inf: no end. scatter: m, by which reset moves the
    start at random in x and y. render_mode: "rgb_array" for pictures of `size` (width, height). The same seed and
    actions give the same numbers, bit for bit.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 50}

    def __init__(self, scene, ticks=10, seconds=10.0, scatter=0.0, render_mode=None, size=(640, 480), **model_options):
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"there is no render_mode {render_mode!r}; there is 'rgb_array'")
        ticks = operator.index(ticks)
        if ticks < 1:
            raise ValueError(f"ticks is {ticks}; a step has at least 1")
        if not seconds > 0:
            raise ValueError(f"seconds is {seconds}; an episode lasts longer than 0 s")
        if not 0 <= scatter < np.inf:
            raise ValueError(f"scatter is {scatter} m; give 0 or more")
        if isinstance(scene, Model):
            _refuse(model_options)
        self.model = scene if isinstance(scene, Model) else Model(scene, **model_options)
        self.simulation = Simulation(self.model)
        self.ticks, self.seconds, self.scatter = ticks, seconds, scatter
        self.render_mode, self.size = render_mode, size
        self.metadata = {**self.metadata, "render_fps": max(1, round(self.model.rate_hz / ticks))}
        self.start = None
        # The body at rest and the tool's start, and a tool's breadth around.
        places = np.vstack([self.simulation.skin_positions(), self.model.tool_start[None, :3]])
        margin = 2 * self.model.tool_radius
        self.action_space = Box(places.min(axis=0) - margin, places.max(axis=0) + margin, dtype=np.float64)
        self.observation_space = Box(-np.inf, np.inf, (17,), dtype=np.float64)

    def pose(self, action):
        """The tool's, (7) or (3), for an action; jaws, materials and the like may be set here, too (self.simulation).
        """
        return action

    def reward(self, state):
        return 0.0

    def terminated(self, state):
        return state.frozen

    @staticmethod
    def observe(state):
        return np.concatenate([state.pose, state.force, state.torque, state.normal, [state.depth]])

    def _begin(self):
        """The body at rest. @return the pose that the tool begins at"""
        self.simulation.reset()
        self.start = self.model.tool_start.copy()
        self.start[:2] += self.np_random.uniform(-self.scatter, self.scatter, 2)
        return self.start

    def _pose_of(self, action):
        return _poses(np.asarray(self.pose(action), dtype=object)[None], self.start[None])[0]

    def _outcome(self, state):
        return self.observe(state), float(self.reward(state)), bool(self.terminated(state)), state.time >= self.seconds

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        # Only as fast as the scene lets the tool go; nothing is touched on the way, high above the skin.
        state = self.simulation.step(self._begin(), self.ticks)
        return self.observe(state), {"state": state}

    def step(self, action):
        if self.start is None:
            raise Error(REFUSED, "reset() the environment before its first step")
        state = self.simulation.step(self._pose_of(action), self.ticks)
        return (*self._outcome(state), {"state": state})

    def render(self):
        """With render_mode "rgb_array" a picture of the present, (height, width, 3) uint8; else None. Needs
        libpalpate_image beside libpalpate."""
        if self.render_mode is None:
            return None
        return np.ascontiguousarray(image(self.simulation, *self.size)[..., :3])

    def close(self):
        self.simulation.close()


class VectorEnv(_VectorEnv):
    """Environments of one model that step side by side on a team of threads, with the bits of one after the other.

    Observations, rewards, terminated and truncated have a row for each; actions are (n, 3) or (n, 7). One that has
    ended begins anew in the next step, whatever its action (gymnasium's AutoresetMode.NEXT_STEP). info["state"] is a
    structured array of states (palpate.STATE). reset(seed=7) seeds them with 7, 8, ...

    threads: 0: one for each core. environment: the class of each, for other actions, observations, rewards and ends: its
    pose, observe, reward and terminated are called, never its step and reset.
    """

    closed = False

    def __init__(self, scene, num_envs, threads=0, environment=Environment, **options):
        if num_envs < 1:
            raise ValueError(f"num_envs is {num_envs}")
        of_model = {name: options.pop(name) for name in ("rate_hz", "cache", "set", "text", "folder", "name")
                    if name in options}
        if isinstance(scene, Model):
            _refuse(of_model)
        model = scene if isinstance(scene, Model) else Model(scene, threads=1, **of_model)
        self.envs = [environment(model, **options) for _ in range(num_envs)]
        first = self.envs[0]
        if not all(isinstance(space, Box) for space in (first.action_space, first.observation_space)):
            raise TypeError("a VectorEnv puts arrays together: the spaces of its environments are Boxes")
        own = [name for name in ("reset", "step") if getattr(type(first), name) is not getattr(Environment, name)]
        if own:
            raise TypeError(f"a VectorEnv does not call {type(first).__name__}.{own[0]}: override pose, observe, reward "
                            "and terminated")
        self.num_envs, self.render_mode, self.threads = num_envs, first.render_mode, threads
        self.metadata = {**first.metadata, **({"autoreset_mode": _autoreset.NEXT_STEP} if _autoreset else {})}
        self.single_action_space, self.single_observation_space = first.action_space, first.observation_space
        self.action_space, self.observation_space = (
            _batched(space, num_envs) for space in (first.action_space, first.observation_space))
        self._team, self._ended = Team(threads), None

    def __getstate__(self):
        return {name: value for name, value in self.__dict__.items() if name != "_team"}

    def __setstate__(self, state):
        self.__dict__.update(state)
        self._team = Team(self.threads)

    def _advance(self, poses):
        """One step of all. @return their states"""
        if self.closed:
            raise Error(BAD_ARGUMENT, "the environments are closed")
        states = step_many([env.simulation for env in self.envs], poses, self.envs[0].ticks, self._team)
        return states, [State(_State.from_buffer_copy(states[k])) for k in range(self.num_envs)]

    def _info(self, states):
        return {"state": states, "_state": np.ones(self.num_envs, dtype=bool)}

    def reset(self, *, seed=None, options=None):
        seeds = [None] * self.num_envs if seed is None else seed if np.ndim(seed) else [
            seed + k for k in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} environments")
        super().reset(seed=None if np.ndim(seed) else seed)
        for env, own in zip(self.envs, seeds):
            super(Environment, env).reset(seed=own)
        states, each = self._advance([env._begin() for env in self.envs])
        self._ended = np.zeros(self.num_envs, dtype=bool)
        return np.stack([env.observe(state) for env, state in zip(self.envs, each)]), self._info(states)

    def step(self, actions):
        if self._ended is None:
            raise Error(REFUSED, "reset() the environments before their first step")
        starts = np.array([env.start for env in self.envs])
        if type(self.envs[0]).pose is not Environment.pose:
            if len(actions) != self.num_envs:
                raise ValueError(f"{len(actions)} actions for {self.num_envs} environments")
            actions = [start if ended else env._pose_of(action)
                       for env, action, start, ended in zip(self.envs, actions, starts, self._ended)]
        poses = _poses(actions, starts)
        for k in np.flatnonzero(self._ended):
            poses[k] = self.envs[k]._begin()
        states, each = self._advance(poses)
        observations, rewards, terminated, truncated = (
            np.array(column) for column in zip(*(env._outcome(state) for env, state in zip(self.envs, each))))
        for column in (rewards, terminated, truncated):
            column[self._ended] = 0  # they have only begun
        self._ended = terminated | truncated
        return observations, rewards, terminated, truncated, self._info(states)

    def render(self):
        """A tuple of their pictures, or None."""
        return None if self.render_mode is None else tuple(env.render() for env in self.envs)

    def close_extras(self, **_):
        for one in [*self.__dict__.get("envs", ()), *filter(None, [self.__dict__.get("_team")])]:
            one.close()
