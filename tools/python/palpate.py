"""Palpate in Python: soft tissue under a tool. One file over ctypes and numpy; nothing to build.

    import palpate
    model = palpate.Model("liver")                # a scene file, or a scene that the library brings
    with palpate.Simulation(model) as simulation:
        state = simulation.step(pose)             # one tick on this thread
        state.force, state.torque, state.depth    # N, N m about the tip, m

Or, in the form that reinforcement learning is used to, `Environment`: reset(seed), step(action), render().

The library is looked for in $PALPATE_LIBRARY (a file), beside an installed copy of this file, and in the release build,
or else the newest, of the source tree that this file is in. Units are m, N, s, rad; a pose is x, y, z, then the
quaternion x, y, z, w. What may be called by which thread, and what each number means, stands in palpate.h.
"""
import ctypes as C
import glob
import operator
import os

import numpy as np

OK, BAD_ARGUMENT, BAD_INPUT, REFUSED, BUSY, FAILED = range(6)
DOUBTS = ("good", "volume", "contact", "squeezed", "step", "energy", "inverted", "lost", "resolution")


class Error(RuntimeError):
    """A call that was not done; `code` is one of those above, the text says why and, for a scene, where."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


class _Sized(C.Structure):
    def __init__(self, **values):
        super().__init__(size=C.sizeof(type(self)), **values)


class _Error(_Sized):
    _fields_ = [("size", C.c_uint32), ("code", C.c_int32), ("text", C.c_char * 1016)]


_Progress = C.CFUNCTYPE(C.c_int, C.c_void_p, C.c_char_p, C.c_double)


class _Options(_Sized):
    _fields_ = [("size", C.c_uint32), ("threads", C.c_int32), ("rate_hz", C.c_double), ("cache_folder", C.c_char_p),
                ("progress", _Progress), ("user", C.c_void_p)]


class _Info(_Sized):
    _fields_ = [("size", C.c_uint32), ("node_count", C.c_int32), ("point_count", C.c_int32),
                ("skin_vertex_count", C.c_int32), ("skin_triangle_count", C.c_int32), ("material_count", C.c_int32),
                ("rate_hz", C.c_double), ("tool_start", C.c_double * 7), ("tool_radius", C.c_double),
                ("first_contact_travel", C.c_double), ("hash", C.c_uint64)]


class _State(_Sized):
    _fields_ = [("size", C.c_uint32), ("doubt", C.c_int32), ("fresh", C.c_int32), ("frozen", C.c_int32),
                ("contact_count", C.c_int32), ("loss_count", C.c_int32), ("tick", C.c_int64),
                ("pose_sequence", C.c_uint64), ("time", C.c_double), ("age", C.c_double), ("pose", C.c_double * 7),
                ("force", C.c_double * 3), ("force_filtered", C.c_double * 3), ("torque", C.c_double * 3),
                ("normal", C.c_double * 3), ("stiffness", C.c_double), ("depth", C.c_double), ("advance", C.c_double),
                ("work", C.c_double), ("expected_error", C.c_double)]


class _ToolState(_Sized):
    _fields_ = [("size", C.c_uint32), ("contact_count", C.c_int32), ("tick", C.c_int64), ("pose", C.c_double * 7),
                ("force", C.c_double * 3), ("torque", C.c_double * 3), ("opening", C.c_double), ("pinch", C.c_double)]


class _Parameter(C.Structure):
    _fields_ = [("name", C.c_char_p), ("values", C.POINTER(C.c_double)), ("count", C.c_int32)]


class State:
    """One tick's outcome: the fields of palpate_state, vectors as numpy arrays."""

    def __init__(self, raw):
        for name, kind in raw._fields_[1:]:
            value = getattr(raw, name)
            setattr(self, name, np.array(value) if issubclass(kind, C.Array) else value)
        self.doubt = DOUBTS[raw.doubt]
        self.fresh, self.frozen = bool(raw.fresh), bool(raw.frozen)

    def __repr__(self):
        return f"State(tick={self.tick}, depth={self.depth:.5g} m, force={self.force} N, {self.doubt})"


class ToolState:
    """One tool's part of a tick's outcome: the fields of palpate_tool_state, vectors as numpy arrays."""

    def __init__(self, raw):
        for name, kind in raw._fields_[1:]:
            value = getattr(raw, name)
            setattr(self, name, np.array(value) if issubclass(kind, C.Array) else value)

    def __repr__(self):
        return f"ToolState(tick={self.tick}, force={self.force} N, pinch={self.pinch:.5g} N)"


def find_library(name="palpate"):
    """The file of lib<name>.so, looked for as the top of this module says."""
    if name == "palpate" and os.environ.get("PALPATE_LIBRARY"):
        return os.environ["PALPATE_LIBRARY"]
    file, here = f"lib{name}.so", os.path.dirname(os.path.realpath(__file__))
    if name != "palpate":  # beside the one in use
        return os.path.join(os.path.dirname(os.path.realpath(find_library())), file)
    up = lambda *parts: os.path.normpath(os.path.join(here, *parts))
    places = glob.glob(up("../../../lib*", file)) + glob.glob(up("../../../lib/*", file))
    places += sorted(glob.glob(up("../../build/*", file)), key=lambda p: ("release" not in p, -os.path.getmtime(p)))
    if not places:
        raise Error(FAILED, f"there is no {file} near {here}; install or build Palpate, or set PALPATE_LIBRARY")
    return places[0]


_NAMES = ("load describe skin_triangles script create step start stop set_target read skin_positions contacts "
          "set_friction set_material reset save restore hash tool_count set_tool_target set_opening read_tool").split()


def _load_library():
    lib = C.CDLL(find_library())
    pointer, pose, size = C.c_void_p, C.POINTER(C.c_double), C.c_size_t
    arguments = {
        "load": [C.c_char_p, C.POINTER(_Options), C.POINTER(pointer), C.POINTER(_Error)],
        "describe": [pointer, C.POINTER(_Info)],
        "skin_triangles": [pointer, pointer, C.c_int32],
        "script": [pointer, C.c_char_p, pointer, C.c_int64, C.POINTER(C.c_int64), C.POINTER(_Error)],
        "create": [pointer, C.POINTER(pointer), C.POINTER(_Error)],
        "step": [pointer, C.c_int64, pose, C.POINTER(_State)],
        "start": [pointer, C.c_uint32],
        "stop": [pointer],
        "set_target": [pointer, pose, C.c_uint64],
        "read": [pointer, C.POINTER(_State)],
        "skin_positions": [pointer, pointer, C.c_int32],
        "contacts": [pointer, pointer, pointer, C.c_int32, C.POINTER(C.c_int32)],
        "set_friction": [pointer, C.c_double],
        "set_material": [pointer, C.c_int32, C.POINTER(_Parameter), C.c_int32, C.POINTER(_Error)],
        "reset": [pointer],
        "save": [pointer, pointer, size],
        "restore": [pointer, pointer, size, C.POINTER(_Error)],
        "hash": [pointer, C.POINTER(C.c_uint64)],
        "tool_count": [pointer, C.POINTER(C.c_int32)],
        "set_tool_target": [pointer, C.c_int32, pose, C.c_uint64],
        "set_opening": [pointer, C.c_int32, C.c_double],
        "read_tool": [pointer, C.c_int32, C.POINTER(_ToolState)],
    }
    for name in _NAMES:
        function = getattr(lib, "palpate_" + name)
        function.argtypes, function.restype = arguments[name], C.c_int32
    for name in ("model_destroy", "destroy"):
        getattr(lib, "palpate_" + name).argtypes, getattr(lib, "palpate_" + name).restype = [pointer], None
    lib.palpate_save_size.argtypes, lib.palpate_save_size.restype = [pointer], size
    for name in ("version", "build", "result_text", "doubt_text"):
        getattr(lib, "palpate_" + name).restype = C.c_char_p
    return lib


_lib = None


def library():
    """The library, loaded when first needed."""
    global _lib
    if _lib is None:
        _lib = _load_library()
    return _lib


def version():
    return library().palpate_version().decode()


def _call(name, *arguments, error=None):
    if arguments and arguments[0] is None:
        raise Error(BAD_ARGUMENT, "the simulation is closed")
    if error is not None:
        arguments += (C.byref(error),)
    code = getattr(library(), "palpate_" + name)(*arguments)
    if code != OK:
        text = error.text.decode(errors="replace") if error is not None else ""
        raise Error(code, text or name + ": " + library().palpate_result_text(code).decode())


def _path(value):
    """A file's name as the library takes it."""
    name = os.fsencode(value)
    if b"\0" in name:
        raise ValueError("a file's name with a zero byte")
    return name


def _pose(value):
    """7 doubles of a pose, or none."""
    if value is None:
        return None
    array = np.ascontiguousarray(value, dtype=np.float64)
    if array.shape != (7,):
        raise ValueError(f"a pose is 7 numbers, x, y, z and a quaternion x, y, z, w; this has the shape {array.shape}")
    return array.ctypes.data_as(C.POINTER(C.c_double))


class Model:
    """A scene made ready to run, which takes seconds. Many simulations may share it.

    cache: folder in which set-ups are kept for the next time.
    """

    def __init__(self, scene, threads=0, rate_hz=0, cache=None):
        self._handle = C.c_void_p()
        options = _Options(threads=threads, rate_hz=rate_hz, cache_folder=_path(cache) if cache else None)
        _call("load", _path(scene), C.byref(options), C.byref(self._handle), error=_Error())
        info = _Info()
        _call("describe", self._handle, C.byref(info))
        self.node_count, self.point_count = info.node_count, info.point_count
        self.material_count, self.rate_hz, self.hash = info.material_count, info.rate_hz, info.hash
        self.skin_vertex_count = info.skin_vertex_count
        self.tool_start, self.tool_radius = np.array(info.tool_start), info.tool_radius
        self.first_contact_travel = info.first_contact_travel
        tools = C.c_int32()
        _call("tool_count", self._handle, C.byref(tools))
        self.tool_count = tools.value
        self.triangles = np.empty((info.skin_triangle_count, 3), dtype=np.int32)
        _call("skin_triangles", self._handle, self.triangles.ctypes.data, len(self.triangles))

    def __del__(self):
        if getattr(self, "_handle", None):
            library().palpate_model_destroy(self._handle)

    @property
    def tool_axis(self):
        """Unit vector along which the tool advances in its start pose."""
        x, y, z, w = self.tool_start[3:]
        return -np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])

    def script(self, name=None):
        """Poses (ticks, 7) of a tool script, by file or name; None: the indentation of an off-screen run."""
        count, text = C.c_int64(), _path(name or "")
        _call("script", self._handle, text, None, 0, C.byref(count), error=_Error())
        poses = np.empty((count.value, 7))
        _call("script", self._handle, text, poses.ctypes.data, len(poses), C.byref(count), error=_Error())
        return poses

    def pose_at(self, depth, slide=(0, 0)):
        """The start pose moved along the tool's axis to `depth` m past first touch, and by `slide` m in x and y."""
        pose = self.tool_start.copy()
        pose[:3] += (self.first_contact_travel + depth) * self.tool_axis
        pose[:2] += slide
        return pose


class Simulation:
    """A body and its tool. One thread calls at a time, but read() is for any; see palpate.h."""

    def __init__(self, model):
        if not isinstance(model, Model):
            raise TypeError(f"a simulation is made of a Model, not of {type(model).__name__}")
        self.model = model
        self._handle = C.c_void_p()
        _call("create", model._handle, C.byref(self._handle), error=_Error())

    def close(self):
        if getattr(self, "_handle", None):
            library().palpate_destroy(self._handle)
            self._handle = None

    __del__ = close

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def step(self, pose=None, ticks=1):
        """Ticks on this thread, the tool at `pose` (7), or where it was. Returns the last one's State."""
        raw = _State()
        _call("step", self._handle, operator.index(ticks), _pose(pose), C.byref(raw))
        return State(raw)

    def start(self, real_time=True):
        """Goes on by itself at the model's rate. real_time: ask the system for real-time scheduling."""
        try:
            _call("start", self._handle, 0 if real_time else 1)
        except Error as error:
            if error.code != REFUSED:
                raise
            raise Error(REFUSED, "a forked process has none of this simulation's threads; make a Simulation in it") \
                from None

    def stop(self):
        _call("stop", self._handle)

    def set_target(self, pose, sequence=0):
        """Where the tool should be while it runs by itself; the latest wins."""
        _call("set_target", self._handle, _pose(pose), sequence)

    def set_tool_target(self, tool, pose, sequence=0):
        """Where one of several tools should be, from the next tick on; the latest wins."""
        _call("set_tool_target", self._handle, tool, _pose(pose), sequence)

    def set_opening(self, opening, tool=0):
        """How far a tool's jaws should be open, m, from the next tick on."""
        _call("set_opening", self._handle, tool, opening)

    def read_tool(self, tool=0):
        """One tool's part of the newest tick: its ToolState."""
        raw = _ToolState()
        _call("read_tool", self._handle, tool, C.byref(raw))
        return ToolState(raw)

    def read(self):
        """The newest tick's State."""
        raw = _State()
        _call("read", self._handle, C.byref(raw))
        return State(raw)

    def skin_positions(self):
        """Where the skin's vertices are: (skin_vertex_count, 3) float32, m. Triangles: model.triangles."""
        positions = np.empty((self.model.skin_vertex_count, 3), dtype=np.float32)
        _call("skin_positions", self._handle, positions.ctypes.data, len(positions))
        return positions

    def contacts(self):
        """Skin vertices (n) and the forces on the tissue there, N (n, 3)."""
        capacity, count = 0, C.c_int32(4096)
        while count.value > capacity:  # once more where there were too many
            capacity = count.value
            vertex, force = np.empty(capacity, dtype=np.int32), np.empty((capacity, 3), dtype=np.float32)
            _call("contacts", self._handle, vertex.ctypes.data, force.ctypes.data, capacity, C.byref(count))
        return vertex[:count.value].copy(), force[:count.value].copy()

    def set_friction(self, coefficient):
        _call("set_friction", self._handle, coefficient)

    def set_material(self, index=0, **parameters):
        """Parameters of a material by the names that scenes give them: set_material(0, young=4000)."""
        values = {name: np.atleast_1d(np.asarray(value, dtype=np.float64)) for name, value in parameters.items()}
        rows = (_Parameter * max(1, len(values)))(*[
            _Parameter(name.encode(), value.ctypes.data_as(C.POINTER(C.c_double)), len(value))
            for name, value in values.items()])
        _call("set_material", self._handle, index, rows, len(values), error=_Error())

    def reset(self):
        """The body at rest again; friction and materials stay as they were set."""
        _call("reset", self._handle)

    def save(self):
        """The whole state as bytes, for restore()."""
        data = C.create_string_buffer(library().palpate_save_size(self._handle))
        _call("save", self._handle, data, len(data))
        return data.raw

    def restore(self, data):
        """Goes on bit for bit from where save() was called."""
        data = bytes(data)
        _call("restore", self._handle, data, len(data), error=_Error())

    def hash(self):
        value = C.c_uint64()
        _call("hash", self._handle, C.byref(value))
        return value.value


class Environment:
    """The customary form.

        observation, info = reset(seed)
        observation, reward, terminated, truncated, info = step(action)

    action       (3) where the tip should be, m, or (7) a pose
    observation  (17) float64: pose of the tool (7), force (3), torque (3), normal (3), depth
    reward       0: override reward(state)
    truncated    after `seconds` of physics time; terminated where the tissue is lost for good (State.frozen)

    ticks: ticks of physics in one step. scatter: m, by which reset(seed) moves the start at random in x and y. The same
    seed and actions give the same numbers, bit for bit.
    """

    def __init__(self, scene, ticks=10, seconds=10.0, scatter=0.0, **model_options):
        self.model = scene if isinstance(scene, Model) else Model(scene, **model_options)
        self.simulation = Simulation(self.model)
        self.ticks, self.seconds, self.scatter = ticks, seconds, scatter
        self.random = np.random.default_rng()
        self.start = None

    def reward(self, state):
        return 0.0

    @staticmethod
    def observe(state):
        return np.concatenate([state.pose, state.force, state.torque, state.normal, [state.depth]])

    def reset(self, seed=None, options=None):
        if seed is not None:
            self.random = np.random.default_rng(seed)
        self.simulation.reset()
        self.start = self.model.tool_start.copy()
        self.start[:2] += self.random.uniform(-self.scatter, self.scatter, 2)
        # Only as fast as the scene lets the tool go; nothing is touched on the way, high above the skin.
        state = self.simulation.step(self.start, self.ticks)
        return self.observe(state), {"state": state}

    def step(self, action):
        if self.start is None:
            raise Error(REFUSED, "reset() the environment before its first step")
        action = np.asarray(action, dtype=np.float64)
        pose = np.concatenate([action, self.start[3:]]) if action.shape == (3,) else action
        state = self.simulation.step(pose, self.ticks)
        truncated = state.time >= self.seconds
        return self.observe(state), self.reward(state), state.frozen, truncated, {"state": state}

    def render(self, width=640, height=480):
        """A picture of the present, (height, width, 4) uint8. Needs libpalpate_image beside libpalpate."""
        return image(self.simulation, width, height)

    def close(self):
        self.simulation.close()


_image = None


def image(simulation, width=640, height=480):
    """A picture of a simulation, drawn off-screen: (height, width, 4) uint8, upper row first."""
    global _image
    if _image is None:
        try:
            _image = C.CDLL(find_library("palpate_image"))
        except OSError as reason:
            raise Error(FAILED, f"no pictures: {reason}; build Palpate with PALPATE_APP=ON") from None
        _image.palpate_image.argtypes = [C.c_void_p, C.c_void_p, C.c_void_p, C.c_int32, C.c_int32, C.POINTER(_Error)]
        _image.palpate_image.restype = C.c_int32
    if simulation._handle is None:
        raise Error(BAD_ARGUMENT, "the simulation is closed")
    rgba, error = np.empty((height, width, 4), dtype=np.uint8), _Error()
    code = _image.palpate_image(simulation._handle, None, rgba.ctypes.data, width, height, C.byref(error))
    if code != OK:
        raise Error(code, error.text.decode(errors="replace"))
    return rgba
