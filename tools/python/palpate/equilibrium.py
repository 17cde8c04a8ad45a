"""Bodies at rest, and what their answers depend on."""
import ctypes as C
import operator

import numpy as np

from ._library import Error, _call, _Error, _MaterialNumber, _Quantity, library
from .model import Model, _doubles, _numbers, _pose

TOOL_FORCE, REGION_FORCE, DISPLACEMENT = range(3)


class Equilibrium:
    """A model's body at rest, in double, with the tool at `pose` (7), or without one; see palpate_settle.

    What is asked of it is a component along `direction` (of any length): of the force on the tool; of what a `region`, by number or
    name, holds the tissue with; or of the displacement of one of `points`, by its number.

        at_rest = palpate.Equilibrium(model, model.pose_at(0.003))
        at_rest.force([0, 0, 1])                                         # N
        at_rest.sensitivity([("lump", "young"), ("gel", "young")], [0, 0, 1])   # N/Pa
    """

    def __init__(self, model, pose=None, time=0.0, threads=0):
        if not isinstance(model, Model):
            raise TypeError(f"an equilibrium is that of a Model, not of {type(model).__name__}")
        self.model, self._handle = model, C.c_void_p()
        _call("settle", model._handle, _pose(pose), time, threads, C.byref(self._handle), error=_Error())

    def close(self):
        if getattr(self, "_handle", None):
            library().palpate_equilibrium_destroy(self._handle)
            self._handle = None

    __del__ = close

    def _quantity(self, direction, region, points, point):
        quantity = _Quantity(kind=TOOL_FORCE)
        if region is not None:
            quantity.kind = REGION_FORCE
            quantity.index = self.model._index(self.model.regions, region, "region")
        elif points is not None:
            quantity.kind, quantity.points = DISPLACEMENT, points._handle.value
            quantity.index = operator.index(point)
        quantity.direction[:] = _numbers(direction, (3,), "a direction")
        return C.byref(quantity)

    def _number(self, material, name, entry=0):
        index = self.model._index(self.model.materials, material, "material")
        return _MaterialNumber(index, operator.index(entry), name.encode())

    def _value(self, *of):
        value = C.c_double()
        _call("equilibrium_value", self._handle, self._quantity(*of), C.byref(value), error=_Error())
        return value.value

    def force(self, direction, region=None):
        """On the tool, N, or what a region holds the tissue with."""
        return self._value(direction, region, None, 0)

    @property
    def expected_error(self):
        """How far off the tool's force is for the nodes that there are, as a share of it."""
        share = C.c_double()
        _call("equilibrium_expected_error", self._handle, C.byref(share))
        return share.value

    def displacement(self, direction, points, point=0):
        """Of one of Points, m."""
        return self._value(direction, None, points, point)

    def set(self, material, name, value, entry=0):
        """Comes to rest with another value of a material's number, the tool where it is."""
        _call("settle_with", self._handle, C.byref(self._number(material, name, entry)), value, error=_Error())

    def sensitivity(self, numbers, direction, region=None, points=None, point=0):
        """Derivatives (n) to numbers [(material, name)] or [(material, name, entry)], by one linear solution."""
        rows = (_MaterialNumber * max(1, len(numbers)))(*[self._number(*number) for number in numbers])
        slopes = np.empty(len(numbers))
        _call("sensitivity", self._handle, self._quantity(direction, region, points, point), rows, len(numbers),
              slopes.ctypes.data_as(C.POINTER(C.c_double)), error=_Error())
        return slopes
