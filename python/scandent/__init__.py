"""Multi-contact climbs for legged robots from a single scan.

    import scandent

    robot = scandent.Robot.load("builtin:hrp2")
    terrain = scandent.perceive(depth, K, T_WV)             # uint16, mm; pose of the optical frame in W
    plan = scandent.plan(terrain, robot, "half_sitting", goal=[2.0, 0.0])
    plan.motion.q, plan.stances[3].forces["left_foot"]      # arrays
    plan.save("out/mine")

Metres, radians, newtons, seconds; W is z up; a pose X_WC is that of C in W. Everything that can go wrong is a
``scandent.Error``.
"""

import os as _os
import sys as _sys

# MuJoCo's functions are looked up when they are first called: its library is another wheel's.
_flags = _sys.getdlopenflags()
_sys.setdlopenflags(_flags & ~_os.RTLD_NOW | _os.RTLD_LAZY)
try:
    from . import _scandent
finally:
    _sys.setdlopenflags(_flags)

from . import datasets, pinocchio
from ._batch import batch
from ._errors import Error, InputError, NoPlan, Refused, Undecided, Unsolved
from ._plan import Certificate, Contact, Motion, Page, Plan, Stance, plan, run, verify
from ._posture import Posture, Postures, Touch, draw_postures, solve_posture, solve_postures
from ._robot import Patch, Robot
from ._scandent import __version__
from ._simulation import Simulation, mjcf, simulate
from ._terrain import Face, Terrain, perceive

__all__ = [
    "Certificate",
    "Contact",
    "Error",
    "Face",
    "InputError",
    "Motion",
    "NoPlan",
    "Page",
    "Patch",
    "Plan",
    "Posture",
    "Postures",
    "Refused",
    "Robot",
    "Simulation",
    "Stance",
    "Terrain",
    "Touch",
    "Undecided",
    "Unsolved",
    "__version__",
    "batch",
    "datasets",
    "draw_postures",
    "perceive",
    "mjcf",
    "pinocchio",
    "plan",
    "run",
    "simulate",
    "solve_posture",
    "solve_postures",
    "verify",
]
