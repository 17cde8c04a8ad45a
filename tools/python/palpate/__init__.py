"""Palpate in Python: soft tissue under a tool. Over ctypes and numpy; nothing to build.

    import palpate
    model = palpate.Model("liver")                # a scene file, or a scene that the library brings
    with palpate.Simulation(model) as simulation:
        state = simulation.step(pose)             # one tick on this thread
        state.force, state.torque, state.depth    # N, N m about the tip, m

Many at once: step_many(simulations, poses). In the form that reinforcement learning is used to: `Environment` and
`VectorEnv` (environment.py). Models and simulations can be pickled: models by what they were made from, simulations by
their state.

The library is looked for in $PALPATE_LIBRARY (a file), beside an installed copy of this package, in the release build,
or else the newest, of the source tree that this is in, and where the system keeps libraries. Units are m, N, s, rad; a
pose is x, y, z, then the quaternion x, y, z, w. What may be called by which thread, and what each number means, stands
in palpate.h.
"""
from ._library import (BAD_ARGUMENT, BAD_INPUT, BUSY, DOUBTS, FAILED, MATERIAL, OK, REFUSED, REGION, RIGID, TOOL, Coupling,
                       Error, SkinPlace, State, ToolState, Wrench, find_library, library, version)
from .equilibrium import Equilibrium
from .model import Model, Points
from .simulation import STATE, Simulation, Team, image, step_many


def __getattr__(name):
    """Environment and VectorEnv, with gymnasium where it is there: it takes long to import."""
    if name in ("Environment", "VectorEnv"):
        from . import environment
        return getattr(environment, name)
    raise AttributeError(f"module 'palpate' has no attribute {name!r}")
