"""The C library as ctypes sees it: palpate.h and palpate_device.h."""
import ctypes as C
import glob
import operator
import os

import numpy as np

ABI = "0.2"  # of the library that the structs here are those of
OK, BAD_ARGUMENT, BAD_INPUT, REFUSED, BUSY, FAILED = range(6)
MATERIAL, TOOL, REGION, RIGID = range(4)
DOUBTS = ("good", "volume", "contact", "squeezed", "step", "energy", "inverted", "lost", "resolution")


class Error(RuntimeError):
    """A call that was not done; `code` is one of those above, the text says why and, for a scene, where."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code

    def __reduce__(self):  # as processes send it to one another
        return type(self), (self.code, str(self))


class _Sized(C.Structure):
    def __init__(self, **values):
        super().__init__(size=C.sizeof(type(self)), **values)


class _Error(_Sized):
    _fields_ = [("size", C.c_uint32), ("code", C.c_int32), ("text", C.c_char * 1016)]


_TickCall = C.CFUNCTYPE(None, C.c_void_p, C.c_void_p)  # user, state
_Progress = C.CFUNCTYPE(C.c_int, C.c_void_p, C.c_char_p, C.c_double)


def _whole(kind):
    """A ctypes integer as an argument that refuses what does not fit, where ctypes would take its lowest bits."""
    bits = 8 * C.sizeof(kind)
    low, high = (0, 2 ** bits - 1) if kind(-1).value > 0 else (-2 ** (bits - 1), 2 ** (bits - 1) - 1)

    class Whole(kind):
        @classmethod
        def from_param(cls, value):
            number = value.value if isinstance(value, C._SimpleCData) else operator.index(value)
            if not low <= number <= high:
                raise ValueError(f"{number} is not within {low} to {high}")
            return kind(number)

    return Whole


_Int32, _Int64, _UInt32, _UInt64 = map(_whole, (C.c_int32, C.c_int64, C.c_uint32, C.c_uint64))


def _fits(kind, value, what):
    """The value of such an integer for a struct's field."""
    try:
        return kind.from_param(value).value
    except ValueError as problem:
        raise ValueError(f"{what}: {problem}") from None


class _Options(_Sized):
    _fields_ = [("size", C.c_uint32), ("threads", C.c_int32), ("rate_hz", C.c_double), ("cache_folder", C.c_char_p),
                ("progress", _Progress), ("user", C.c_void_p), ("set", C.POINTER(C.c_char_p)),
                ("set_count", C.c_int32)]


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
                ("force", C.c_double * 3), ("torque", C.c_double * 3), ("opening", C.c_double), ("pinch", C.c_double),
                ("expected_error", C.c_double)]


class _Parameter(C.Structure):
    _fields_ = [("name", C.c_char_p), ("values", C.POINTER(C.c_double)), ("count", C.c_int32)]


class _SkinPlace(_Sized):
    _fields_ = [("size", C.c_uint32), ("triangle", C.c_int32), ("distance", C.c_double), ("point", C.c_double * 3),
                ("normal", C.c_double * 3), ("barycentric", C.c_double * 3)]


class _Device(_Sized):
    _fields_ = [("size", C.c_uint32), ("locked", C.c_int32)] + [(name, C.c_double) for name in (
        "stiffness", "damping", "max_force", "rise_time", "scale", "own_damping", "lever")]


class _DevicePose(_Sized):
    _fields_ = [("size", C.c_uint32), ("sequence", C.c_uint32), ("felt", C.c_uint32), ("has_velocity", C.c_int32),
                ("sent_ns", C.c_int64), ("pose", C.c_double * 7), ("velocity", C.c_double * 3)]


class _Wrench(_Sized):
    _fields_ = [("size", C.c_uint32), ("touching", C.c_int32), ("sequence", C.c_uint32), ("answers", C.c_uint32),
                ("force", C.c_double * 3), ("torque", C.c_double * 3)]


class _Coupling(_Sized):
    _fields_ = [("size", C.c_uint32), ("engaged", C.c_int32), ("poses", C.c_int64), ("silences", C.c_int64),
                ("fades", C.c_int64)] + [(name, C.c_double) for name in (
                    "stiffness", "delay", "energy", "lowest_energy", "damped", "peak_force", "peak_torque", "slipped")]


class _MaterialNumber(C.Structure):
    _fields_ = [("material", C.c_int32), ("entry", C.c_int32), ("name", C.c_char_p)]


class _Quantity(_Sized):
    _fields_ = [("size", C.c_uint32), ("kind", C.c_int32), ("index", C.c_int32), ("unused", C.c_int32),
                ("points", C.c_void_p), ("direction", C.c_double * 3)]


class Record:
    """The fields of a struct of the library, vectors as numpy arrays over its memory."""

    def __init__(self, raw):
        for name, kind in raw._fields_[1:]:
            value = getattr(raw, name)
            setattr(self, name, np.ctypeslib.as_array(value) if issubclass(kind, C.Array) else value)

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{name}={value}' for name, value in vars(self).items())})"


class State(Record):
    """One tick's outcome: the fields of palpate_state. Equal where all but the wall time (age, fresh) is."""

    def __init__(self, raw):
        super().__init__(raw)
        self.doubt = DOUBTS[raw.doubt]
        self.fresh, self.frozen = bool(raw.fresh), bool(raw.frozen)

    def __eq__(self, other):
        if not isinstance(other, State):
            return NotImplemented
        names = vars(self).keys() - {"age", "fresh"}
        return names == vars(other).keys() - {"age", "fresh"} and all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    __hash__ = None

    def __repr__(self):
        return f"State(tick={self.tick}, depth={self.depth:.5g} m, force={self.force} N, {self.doubt})"


class ToolState(Record):
    """One tool's part of a tick's outcome: the fields of palpate_tool_state."""


class SkinPlace(Record):
    """A place on the skin: triangle, distance (m), point, normal, barycentric."""


class Wrench(Record):
    """What a device is to push its handle with: force (N), torque (N m)."""


class Coupling(Record):
    """What a device's coupling has seen: the fields of palpate_coupling_state."""


def find_library(name="palpate"):
    """The file of lib<name>.so, looked for as the top of this module says."""
    if name == "palpate" and os.environ.get("PALPATE_LIBRARY"):
        return os.environ["PALPATE_LIBRARY"]
    file, here = f"lib{name}.so", os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    versioned = f"{file}.{ABI}"
    if name != "palpate":  # beside the one in use
        used = find_library()
        beside = os.path.join(os.path.dirname(os.path.realpath(used)), file) if "/" in used else versioned
        return beside if os.path.exists(beside) or "/" not in used else f"{beside}.{ABI}"
    up = lambda *parts: os.path.normpath(os.path.join(here, *parts))
    places = [place for file in (file, versioned) for lib in ("lib*", "lib/*")
              for place in glob.glob(up("../../..", lib, file))]
    places += sorted(glob.glob(up("../../build/*", file)), key=lambda p: ("release" not in p, -os.path.getmtime(p)))
    if places:
        return places[0]
    try:
        C.CDLL(versioned)
    except OSError:
        raise Error(FAILED, f"there is no {file} near {here}, nor {versioned} where the system keeps libraries; "
                            "install or build Palpate, or set PALPATE_LIBRARY") from None
    return versioned


def _load_library():
    lib = C.CDLL(find_library())
    pointer, pose, size, number = C.c_void_p, C.POINTER(C.c_double), C.c_size_t, _Int32
    to, error = C.POINTER, C.POINTER(_Error)
    arguments = {
        "load": [C.c_char_p, to(_Options), to(pointer), error],
        "load_text": [C.c_char_p, C.c_char_p, C.c_char_p, to(_Options), to(pointer), error],
        "describe": [pointer, to(_Info)],
        "count": [pointer, number, to(C.c_int32)],
        "index": [pointer, number, C.c_char_p],
        "skin_triangles": [pointer, pointer, number],
        "script": [pointer, C.c_char_p, pointer, _Int64, to(C.c_int64), error],
        "script_openings": [pointer, C.c_char_p, pointer, _Int64, to(C.c_int64), error],
        "create": [pointer, to(pointer), error],
        "step": [pointer, _Int64, pose, to(_State)],
        "team_create": [number, to(pointer), error],
        "step_many": [pointer, pointer, number, _Int64, pointer, pointer, error],
        "start": [pointer, C.c_uint32],
        "stop": [pointer],
        "set_target": [pointer, pose, _UInt64],
        "read": [pointer, to(_State)],
        "skin_positions": [pointer, pointer, number],
        "contacts": [pointer, pointer, pointer, number, to(C.c_int32)],
        "contact_points": [pointer, pointer, pointer, pointer, pointer, number, to(C.c_int32)],
        "closest": [pointer, pose, to(_SkinPlace)],
        "ray": [pointer, pose, pose, to(_SkinPlace)],
        "reactions": [pointer, pointer, pointer, number],
        "rigid_forces": [pointer, pointer, number],
        "pin_force": [pointer, number, pose],
        "points_create": [pointer, pointer, number, to(pointer), error],
        "points_of": [pointer, number, to(pointer), error],
        "points_rest": [pointer, pointer, pointer, number],
        "displacements": [pointer, pointer, pointer, number],
        "velocities": [pointer, pointer, pointer, number],
        "stresses": [pointer, pointer, pointer, pointer, number],
        "set_tool_friction": [pointer, number, C.c_double],
        "set_material": [pointer, number, to(_Parameter), number, error],
        "material_parameter": [pointer, number, number, to(_Parameter)],
        "set_gravity": [pointer, pose],
        "set_force": [pointer, number, pose],
        "pull": [pointer, number, pose],
        "pin": [pointer, number, pose],
        "move_region": [pointer, number, pose],
        "record_start": [pointer, error],
        "record_stop": [pointer, C.c_char_p, error],
        "settle": [pointer, pose, C.c_double, number, to(pointer), error],
        "settle_with": [pointer, to(_MaterialNumber), C.c_double, error],
        "equilibrium_expected_error": [pointer, pose],
        "equilibrium_value": [pointer, to(_Quantity), pose, error],
        "sensitivity": [pointer, to(_Quantity), to(_MaterialNumber), number, pose, error],
        "on_tick": [pointer, _TickCall, pointer],
        "reset": [pointer],
        "save": [pointer, pointer, size],
        "restore": [pointer, pointer, size, error],
        "hash": [pointer, to(C.c_uint64)],
        "set_tool_target": [pointer, number, pose, _UInt64],
        "set_opening": [pointer, number, C.c_double],
        "read_tool": [pointer, number, to(_ToolState)],
        "scene_device": [pointer, to(_Device)],
        "couple": [pointer, to(_Device), error],
        "uncouple": [pointer],
        "exchange": [pointer, _Int64, to(_DevicePose), to(_Wrench)],
        "read_coupling": [pointer, to(_Coupling)],
    }
    for name, types in arguments.items():
        function = getattr(lib, "palpate_" + name)
        function.argtypes, function.restype = types, C.c_int32
    for name in ("model_destroy", "destroy", "team_destroy", "points_destroy", "equilibrium_destroy"):
        getattr(lib, "palpate_" + name).argtypes, getattr(lib, "palpate_" + name).restype = [pointer], None
    lib.palpate_save_size.argtypes, lib.palpate_save_size.restype = [pointer], size
    lib.palpate_name.argtypes, lib.palpate_name.restype = [pointer, number, number], C.c_char_p
    for name in ("version", "build", "result_text", "doubt_text", "last_error"):
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
        raise Error(BAD_ARGUMENT, "it is closed")
    if error is not None:
        arguments += (C.byref(error),)
    try:
        code = getattr(library(), "palpate_" + name)(*arguments)
    except C.ArgumentError as problem:
        raise ValueError(f"{name}: {problem}") from None
    if code != OK:
        text = error.text.decode(errors="replace") if error is not None else ""
        raise Error(code, text or name + ": " + library().palpate_last_error().decode(errors="replace"))


def _path(value):
    """A file's name as the library takes it."""
    name = os.fsencode(value)
    if b"\0" in name:
        raise ValueError("a file's name with a zero byte")
    return name
