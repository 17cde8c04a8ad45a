"""Simulations, one or many at once, and their pictures."""
import ctypes as C
import operator
import os

import numpy as np

from ._library import (BAD_ARGUMENT, FAILED, OK, Coupling, Error, SkinPlace, State, ToolState, Wrench, _call,
                       _Coupling, _Device, _DevicePose, _Error, _fits, _Int64, _Parameter, _Sized, _SkinPlace, _State,
                       _TickCall, _ToolState, _UInt32, _Wrench, find_library, library)
from .model import Model, _doubles, _numbers, _pose


def _simulation_again(model, saved):
    simulation = Simulation(model)
    simulation.restore(saved)
    return simulation


class Simulation:
    """A body and its tool. One thread calls at a time, but read() is for any; see palpate.h."""

    def __init__(self, model):
        if not isinstance(model, Model):
            raise TypeError(f"a simulation is made of a Model, not of {type(model).__name__}")
        self.model = model
        self._handle = C.c_void_p()
        self._raised = []  # by what on_tick() calls
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

    def __reduce__(self):
        return _simulation_again, (self.model, self.save())

    def step(self, pose=None, ticks=1):
        """Ticks on this thread, the tool at `pose` (7), or where it was. Returns the last one's State."""
        raw = _State()
        _call("step", self._handle, operator.index(ticks), _pose(pose), C.byref(raw))
        self._raise_told()
        return State(raw)

    def _raise_told(self):
        if self._raised:
            first = self._raised[0]
            self._raised.clear()
            raise first

    def start(self, real_time=True):
        """Goes on by itself at the model's rate. real_time: ask the system for real-time scheduling."""
        _call("start", self._handle, 0 if real_time else 1)

    def stop(self):
        _call("stop", self._handle)
        self._raise_told()

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

    def skin_positions(self, out=None):
        """Where the skin's vertices are: (skin_vertex_count, 3) float32, m. Triangles: model.triangles."""
        out = self._out(out, (self.model.skin_vertex_count, 3), np.float32)
        _call("skin_positions", self._handle, out.ctypes.data, len(out))
        return out

    @staticmethod
    def _out(out, shape, dtype=np.float64):
        """The caller's array, or a new one."""
        if out is None:
            return np.empty(shape, dtype=dtype)
        if out.shape != shape or out.dtype != dtype or not out.flags.c_contiguous or not out.flags.writeable:
            raise ValueError(f"out must be a writeable, contiguous array {shape} of {np.dtype(dtype)}")
        return out

    def contacts(self):
        """Skin vertices (n) and the forces on the tissue there, N (n, 3)."""
        return self._all("contacts", [((), np.int32), ((3,), np.float32)])

    def contact_points(self):
        """Where tools touch: position, normal towards the tool, force on the tissue, N (n, 3 each), and tool (n)."""
        return self._all("contact_points", 3 * [((3,), np.float64)] + [((), np.int32)])

    def _all(self, call, kinds):
        capacity, count = 0, C.c_int32(1024)
        while count.value > capacity:  # once more where there were too many
            capacity = count.value
            arrays = [np.empty((capacity, *shape), dtype=dtype) for shape, dtype in kinds]
            _call(call, self._handle, *(array.ctypes.data for array in arrays), capacity, C.byref(count))
        return tuple(array[:count.value] for array in arrays)

    def closest(self, x):
        """The skin's SkinPlace that is closest to x; its distance is negative inside the body."""
        raw = _SkinPlace()
        _call("closest", self._handle, _doubles(_numbers(x, (3,), "a place")), C.byref(raw))
        return SkinPlace(raw)

    def ray(self, origin, direction):
        """The SkinPlace that a ray meets first, or None."""
        raw = _SkinPlace()
        _call("ray", self._handle, _doubles(_numbers(origin, (3,), "an origin")),
              _doubles(_numbers(direction, (3,), "a direction")), C.byref(raw))
        return SkinPlace(raw) if raw.triangle >= 0 else None

    def reactions(self):
        """What holds the tissue at each region: {name: (force (3), N, moment (3), N m)}."""
        force, moment = np.empty((2, len(self.model.regions), 3))
        _call("reactions", self._handle, force.ctypes.data, moment.ctypes.data, len(force))
        return {name: (force[k], moment[k]) for k, name in enumerate(self.model.regions)}

    def rigid_forces(self):
        """What each rigid body presses the tissue with: {name: force (3), N}."""
        force = np.empty((len(self.model.rigid), 3))
        _call("rigid_forces", self._handle, force.ctypes.data, len(force))
        return dict(zip(self.model.rigid, force))

    def _field(self, call, points, out):
        out = self._out(out, (len(points), 3))
        _call(call, self._handle, points._handle, out.ctypes.data, len(points))
        return out

    def displacements(self, points, out=None):
        """Of Points, m (n, 3)."""
        return self._field("displacements", points, out)

    def velocities(self, points, out=None):
        """Of Points in the last step, m/s (n, 3)."""
        return self._field("velocities", points, out)

    def stresses(self, points):
        """Cauchy stresses of Points, Pa (n, 3, 3), and volumes over those at rest (n)."""
        stress, J = np.empty((len(points), 3, 3)), np.empty(len(points))
        _call("stresses", self._handle, points._handle, stress.ctypes.data, J.ctypes.data, len(points))
        return stress, J

    def couple(self, **settings):
        """Hangs the tool on a haptic device: those of palpate_device_settings that are not to be the scene's."""
        device = _Device()
        _call("scene_device", self.model._handle, C.byref(device))
        for name, value in settings.items():
            if name not in (field for field, _ in _Device._fields_[1:]):
                raise TypeError(f"a coupling has no {name!r}")
            if name == "locked" and value not in (0, 1):
                raise ValueError(f"locked is {value!r}, not True or False")
            setattr(device, name, int(value) if name == "locked" else value)
        _call("couple", self._handle, C.byref(device), error=_Error())

    def uncouple(self):
        _call("uncouple", self._handle)

    def exchange(self, pose=None, sequence=0, felt=0, velocity=None, sent_ns=0, now_ns=0):
        """One exchange with the device: its newest pose (7), or None, in; the Wrench for its handle out. The Error of a
        pose that can't be one has the wrench that is to be sent all the same."""
        given, wrench = None, _Wrench()
        if pose is not None:
            given = _DevicePose(sequence=_fits(_UInt32, sequence, "sequence"), felt=_fits(_UInt32, felt, "felt"),
                                has_velocity=velocity is not None, sent_ns=_fits(_Int64, sent_ns, "sent_ns"))
            given.pose[:] = np.asarray(pose, dtype=np.float64)
            if velocity is not None:
                given.velocity[:] = np.asarray(velocity, dtype=np.float64)
            given = C.byref(given)
        try:
            _call("exchange", self._handle, now_ns, given, C.byref(wrench))
        except Error as error:
            error.wrench = Wrench(wrench)
            raise
        return Wrench(wrench)

    def coupling(self):
        """What the device's coupling has seen: its Coupling."""
        raw = _Coupling()
        _call("read_coupling", self._handle, C.byref(raw))
        return Coupling(raw)

    def set_friction(self, coefficient, tool=0):
        """Coulomb coefficient of a tool (0: the first), 0 to 2, from the next tick on."""
        _call("set_tool_friction", self._handle, operator.index(tool), coefficient)

    def set_material(self, material=0, **parameters):
        """Parameters of a material, by its number or name, as a scene writes them: set_material("lump", young=4000),
        set_material(relaxation=[[0.3, 0.1], [0.2, 2.0]])."""
        index = self.model._index(self.model.materials, material, "material")
        values = {name: np.ascontiguousarray(value, dtype=np.float64) for name, value in parameters.items()}
        for name, value in values.items():
            if value.ndim > 2 or (value.ndim == 2 and value.shape[1] != 2):
                raise ValueError(f"{name} of the shape {value.shape}: give a number, a list or a list of pairs")
        rows = (_Parameter * max(1, len(values)))(*[
            _Parameter(name.encode(), value.ctypes.data_as(C.POINTER(C.c_double)), value.size)
            for name, value in values.items()])
        _call("set_material", self._handle, index, rows, len(values), error=_Error())

    def material(self, material=0):
        """A material's parameters by their names, as set_material() takes them: as they were set last, or loaded."""
        index, parameters, raw = self.model._index(self.model.materials, material, "material"), {}, _Parameter()
        while True:
            _call("material_parameter", self._handle, index, len(parameters), C.byref(raw))
            if raw.name is None:
                return parameters
            name, values = raw.name.decode(), raw.values[:raw.count]
            if name == "relaxation":
                values = [values[k:k + 2] for k in range(0, raw.count, 2)]
            parameters[name] = values[0] if raw.count == 1 else values

    def set_gravity(self, acceleration):
        """Gravity of the tissue (3), m/s^2, in place of the scene's, from the next tick on; each component up to
        1000."""
        _call("set_gravity", self._handle, _doubles(_numbers(acceleration, (3,), "an acceleration")))

    def set_force(self, vertex, force):
        """A force on a vertex of the skin (3), N, from the next tick on, until it is set to 0. At most 64 vertices."""
        if operator.index(vertex) < 0:
            raise ValueError(f"there is no vertex {vertex}; clear_forces() ends all forces")
        _call("set_force", self._handle, operator.index(vertex), _doubles(_numbers(force, (3,), "a force")))

    def clear_forces(self):
        _call("set_force", self._handle, -1, None)

    def pin(self, vertex, place):
        """Holds a vertex of the skin at a place (3), m, from the next tick on; set anew, it moves it. At most 64."""
        _call("pin", self._handle, operator.index(vertex), _doubles(_numbers(place, (3,), "a place")))

    def unpin(self, vertex=-1):
        """Lets a pinned vertex go, or all of them."""
        _call("pin", self._handle, operator.index(vertex), None)

    def pin_force(self, vertex):
        """What a pin did to the tissue in the newest step (3), N; 0: it is not pinned. Not while it runs on its own."""
        force = np.empty(3)
        _call("pin_force", self._handle, operator.index(vertex), force.ctypes.data_as(C.POINTER(C.c_double)))
        return force

    def move_region(self, region, shift):
        """Moves a region (3), m, by its number or name, beside what the scene says of it."""
        _call("move_region", self._handle, self.model._index(self.model.regions, region, "region"),
              _doubles(_numbers(shift, (3,), "a shift")))

    def start_recording(self):
        """Records all input from here on: before the first tick, or after a reset."""
        _call("record_start", self._handle, error=_Error())

    def stop_recording(self, path=None):
        """Writes what `palpate SCENE --replay PATH` repeats bit for bit; None: nothing."""
        _call("record_stop", self._handle, None if path is None else os.fsencode(path), error=_Error())

    def pull(self, vertex, place):
        """A spring draws a vertex of the skin to a place (3), m, from the next tick on."""
        _call("pull", self._handle, vertex, _doubles(_numbers(place, (3,), "a place")))

    def release(self):
        """Ends the pull."""
        _call("pull", self._handle, -1, None)

    def on_tick(self, call):
        """call(state) after each tick, on the thread that has done it; None: no more. The ticks go on where it raises:
        the first exception then comes out of step(), or of stop(). Python is too slow for a simulation that runs in
        real time beside a hand."""
        if call is not None and not callable(call):
            raise TypeError(f"call must be a function of a State, or None, not {call!r}")
        raised = self._raised  # not the simulation, which would keep itself alive

        def tell(_, raw):
            try:
                call(State(_State.from_buffer_copy(C.string_at(raw, C.sizeof(_State)))))
            except BaseException as error:
                raised[:] = raised or [error]

        told = _TickCall() if call is None else _TickCall(tell)
        _call("on_tick", self._handle, told, None)
        self._told = told  # it must live as long as the library may call it

    def reset(self):
        """The body at rest again; friction, materials and loads stay as they were set."""
        _call("reset", self._handle)

    def save(self):
        """The whole state as bytes, for restore(). Targets and openings that were set since the last tick are not in
        it, unless step(ticks=0) takes them first."""
        size = library().palpate_save_size(self._handle)
        data = C.create_string_buffer(size)
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


class Team:
    """Threads that step simulations side by side; threads=0: one for each core that the process may use."""

    def __init__(self, threads=0):
        self._handle = C.c_void_p()
        _call("team_create", threads, C.byref(self._handle), error=_Error())

    def close(self):
        if getattr(self, "_handle", None):
            library().palpate_team_destroy(self._handle)
            self._handle = None

    __del__ = close


STATE = np.dtype(_State)  # of step_many's states


def step_many(simulations, poses=None, ticks=1, team=None, states=None):
    """Ticks of many simulations, with the bits of one after the other.

    poses: (n, 7); None: the tools stay. team: on which threads; None: the calling one. Returns states (n), a structured
    array with the fields of palpate_state, which may be given: states["force"] is (n, 3). A ValueError or Error names
    the simulation that is wrong, and then none has moved.
    """
    for k, simulation in enumerate(simulations):
        if not isinstance(simulation, Simulation) or not simulation._handle:
            raise Error(BAD_ARGUMENT, f"simulation {k}: it is closed, or none")
    if team is not None and not team._handle:
        raise Error(BAD_ARGUMENT, "the team is closed")
    count = len(simulations)
    if states is None:
        states = np.zeros(count, dtype=STATE)
    Simulation._out(states, (count,), STATE)
    states["size"] = STATE.itemsize
    poses = None if poses is None else _numbers(poses, (count, 7), "poses").ctypes.data_as(C.c_void_p)
    handles = (C.c_void_p * max(1, count))(*[simulation._handle for simulation in simulations])
    error = _Error()
    code = library().palpate_step_many(team._handle if team else None, handles, count, operator.index(ticks), poses,
                                       states.ctypes.data, C.byref(error))
    if code != OK:
        raise Error(code, error.text.decode(errors="replace"))
    for simulation in simulations:
        simulation._raise_told()
    return states


_image = None


class _Camera(_Sized):
    _fields_ = [("size", C.c_uint32), ("reserved", C.c_uint32), ("target", C.c_double * 3), ("distance", C.c_double),
                ("azimuth_deg", C.c_double), ("elevation_deg", C.c_double), ("fov_deg", C.c_double)]


def image(simulation, width=640, height=480, camera={}):
    """A picture of a simulation, drawn off-screen: (height, width, 4) uint8, upper row first.

    camera: {"target": (x, y, z), "distance": m, "azimuth_deg":, "elevation_deg":, "fov_deg":}; what it leaves out is
    the scene's."""
    global _image
    if _image is None:
        try:
            _image = C.CDLL(find_library("palpate_image"))
        except OSError as reason:
            raise Error(FAILED, f"no pictures: {reason}; build Palpate with PALPATE_APP=ON") from None
        _image.palpate_image.argtypes = [C.c_void_p, C.c_void_p, C.c_void_p, C.c_int32, C.c_int32, C.POINTER(_Error)]
        _image.palpate_image.restype = _image.palpate_scene_camera.restype = C.c_int32
        _image.palpate_scene_camera.argtypes = [C.c_void_p, C.POINTER(_Camera)]
    if simulation._handle is None:
        raise Error(BAD_ARGUMENT, "the simulation is closed")
    rgba, error = np.empty((height, width, 4), dtype=np.uint8), _Error()
    view = _Camera()
    _image.palpate_scene_camera(simulation._handle, C.byref(view))
    for name, value in camera.items():
        if name not in ("target", "distance", "azimuth_deg", "elevation_deg", "fov_deg"):
            raise TypeError(f"a camera has no {name!r}")
        setattr(view, name, tuple(value) if name == "target" else value)
    code = _image.palpate_image(simulation._handle, C.byref(view), rgba.ctypes.data, width, height, C.byref(error))
    if code != OK:
        raise Error(code, error.text.decode(errors="replace"))
    return rgba
