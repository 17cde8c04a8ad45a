"""Models, and the points that they are asked at."""
import ctypes as C
import json
import operator
import os
from collections.abc import Mapping

import numpy as np

from ._library import BAD_INPUT, MATERIAL, REGION, RIGID, TOOL, Error, _call, _Error, _Info, _Int32, _Options, _path, library


def _numbers(value, shape, what):
    """Doubles of that shape (None: any length), all finite; else a ValueError that names the first that is not."""
    array = np.ascontiguousarray(value, dtype=np.float64)
    if array.ndim != len(shape) or any(n is not None and n != have for n, have in zip(shape, array.shape)):
        wanted = ", ".join("n" if n is None else str(n) for n in shape)
        raise ValueError(f"{what} of the shape {array.shape}, not ({wanted})")
    if not np.isfinite(array).all():
        place = np.argwhere(~np.isfinite(array))[0]
        raise ValueError(f"{what}: [{', '.join(map(str, place))}] is {array[tuple(place)]}")
    return array


def _pose(value):
    """7 doubles of a pose, or none."""
    if value is None:
        return None
    return _doubles(_numbers(value, (7,), "a pose (x, y, z and a quaternion x, y, z, w)"))


def _doubles(array):
    return array.ctypes.data_as(C.POINTER(C.c_double))


def _toml(key, value):
    """A value as TOML writes it."""
    value = value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
    if isinstance(value, Mapping):
        raise TypeError(f"set: {key!r} can't be a table; name its keys one by one, like \"tool.radius\"")
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)  # inf and nan as TOML has them
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_toml(key, entry) for entry in value)}]"
    raise TypeError(f"set: {key!r} is {type(value).__name__}, not a number, a truth value, a text or a list of them")


def _change(key, value):
    """A key of the scene with another value, as TOML writes it."""
    return f"{key} = {_toml(key, value)}".encode()


def _model_again(made_from, hash):
    model = Model(**made_from)
    if model.hash != hash:
        raise Error(BAD_INPUT, f"{model} is another than the one that was pickled: its scene's files or the library "
                               "have changed")
    return model


class Model:
    """A scene made ready to run, which takes seconds. Many simulations may share it.

    scene: a file, or the name of a scene that the library brings. Or text: the scene itself, whose paths start from
    folder, and which errors call name.
    set: keys that get other values, {"material[0].young": 4000, "tool.radius": 0.01}. cache: folder in which set-ups
    are kept for the next time.
    first_contact_travel: m from the start along the tool's axis to the resting skin; 0 where the tool touches it at the
    start, and where it never meets it that way.
    """

    def __init__(self, scene=None, threads=0, rate_hz=0, cache=None, *, set=None, text=None, folder=None, name=None):
        if (scene is None) == (text is None):
            raise TypeError("a model is made of a scene or of a text")
        if text is not None and "\0" in text:
            raise ValueError("a scene's text with a zero byte")
        self._handle = C.c_void_p()
        changes = [_change(key, value) for key, value in (set or {}).items()]
        options = _Options(threads=_Int32.from_param(threads).value, rate_hz=rate_hz,
                           cache_folder=_path(cache) if cache else None,
                           set=(C.c_char_p * max(1, len(changes)))(*changes), set_count=len(changes))
        out = C.byref(options), C.byref(self._handle)
        if text is None:
            _call("load", _path(scene), *out, error=_Error())
        else:
            _call("load_text", text.encode(), _path(folder or ""), (name or "scene text").encode(), *out,
                  error=_Error())
        absolute = lambda path: os.path.abspath(path) if path else path
        self._made_from = dict(threads=threads, rate_hz=rate_hz, cache=absolute(cache), set=dict(set or {}), text=text,
                               scene=absolute(scene) if scene is not None and os.path.isfile(scene) else scene,
                               folder=os.path.abspath(folder or "") if text is not None else None, name=name)
        info = _Info()
        _call("describe", self._handle, C.byref(info))
        self.node_count, self.point_count = info.node_count, info.point_count
        self.material_count, self.rate_hz, self.hash = info.material_count, info.rate_hz, info.hash
        self.skin_vertex_count = info.skin_vertex_count
        self.tool_start, self.tool_radius = np.array(info.tool_start), info.tool_radius
        self.first_contact_travel = info.first_contact_travel
        self.materials, self.tools, self.regions, self.rigid = (
            self._names(kind) for kind in (MATERIAL, TOOL, REGION, RIGID))
        self.tool_count = len(self.tools)
        self.triangles = np.empty((info.skin_triangle_count, 3), dtype=np.int32)
        _call("skin_triangles", self._handle, self.triangles.ctypes.data, len(self.triangles))

    def _names(self, kind):
        count = C.c_int32()
        _call("count", self._handle, kind, C.byref(count))
        return [library().palpate_name(self._handle, kind, k).decode(errors="replace") for k in range(count.value)]

    def _index(self, names, entry, what):
        """The number of a name, or that number."""
        if not isinstance(entry, str):
            return operator.index(entry)
        if entry not in names:
            raise ValueError(f"there is no {what} {entry!r}; there are {', '.join(names)}")
        return names.index(entry)

    def __reduce__(self):
        return _model_again, (self._made_from, self.hash)

    def __deepcopy__(self, memo):
        return self  # it never changes

    def __repr__(self):
        return f"Model({self._made_from['scene'] or self._made_from['name'] or 'scene text'!r})"

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

    def script_openings(self, name=None):
        """How far that script has the first tool's jaws open, m, in each tick; none where it is no jaws."""
        count, text = C.c_int64(), _path(name or "")
        _call("script_openings", self._handle, text, None, 0, C.byref(count), error=_Error())
        openings = np.empty(count.value)
        _call("script_openings", self._handle, text, openings.ctypes.data, len(openings), C.byref(count),
              error=_Error())
        return openings

    def pose_at(self, depth, slide=(0, 0)):
        """The start pose moved along the tool's axis to `depth` m past first touch, and by `slide` m in x and y. From
        the start pose itself where first_contact_travel is 0."""
        pose = self.tool_start.copy()
        pose[:3] += (self.first_contact_travel + depth) * self.tool_axis
        pose[:2] += slide
        return pose


class Points:
    """Material points of which fields are asked: X (n, 3), m, where they are at rest; or Points.nodes(model), and
    Points.integration(model), the model's own, whose `volume` (n), m^3, is what each stands for."""

    volume = None

    def __init__(self, model, X):
        X = _numbers(X, (None, 3), "points")
        self._make(model, len(X), "points_create", X.ctypes.data, len(X))

    def _make(self, model, count, call, *arguments):
        self.model, self._handle = model, C.c_void_p()
        _call(call, model._handle, *arguments, C.byref(self._handle), error=_Error())
        self.X = np.empty((count, 3))
        _call("points_rest", self._handle, self.X.ctypes.data, None, count)
        return self

    @classmethod
    def nodes(cls, model):
        return cls.__new__(cls)._make(model, model.node_count, "points_of", 0)

    @classmethod
    def integration(cls, model):
        points = cls.__new__(cls)._make(model, model.point_count, "points_of", 1)
        points.volume = np.empty(len(points))
        _call("points_rest", points._handle, None, points.volume.ctypes.data, len(points))
        return points

    def __len__(self):
        return len(self.X)

    def __del__(self):
        if getattr(self, "_handle", None):
            library().palpate_points_destroy(self._handle)
