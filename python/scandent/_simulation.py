"""Plans in MuJoCo: the library is that of its own wheel."""

from __future__ import annotations

import ctypes
import importlib.util
import io
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Union

import numpy as np

from . import _scandent
from ._arguments import Array, Config, PathLike, each, options, path, text, whole
from ._errors import InputError

_WORLDS = ("known", "true", "planned")
_KINDS = ("all", "friction", "mass", "surfaces", "pushes", "sensing")


def load_mujoco() -> None:
    """Loads MuJoCo's library where all find its functions. Raises ``InputError`` where it is not installed."""
    version = _scandent.MUJOCO_VERSION
    found = importlib.util.find_spec("mujoco")
    name = f"libmujoco.{version}.dylib" if sys.platform == "darwin" else f"libmujoco.so.{version}"
    places = [Path(folder) / name for folder in (found.submodule_search_locations or [])] if found else []
    for place in places:
        if place.exists():
            ctypes.CDLL(str(place), mode=ctypes.RTLD_GLOBAL)
            return
    raise InputError(f"simulation and MJCF need MuJoCo {version}: pip install mujoco=={version}")


@dataclass(frozen=True)
class Simulation:
    """What a simulation showed."""

    #: Whether every criterion holds.
    passes: bool
    #: Those that do not, in words.
    failures: List[str]
    #: All of it, as ``simulation.json``: ``stances``, ``execution``, ``robust``, ``robustness``.
    record: Dict[str, Any]
    #: The executed motion by column, each (n,): ``t_s``, the base's pose, joints, ``PATCH_n`` (normal force, N),
    #: ``com_error_m``, ``tilt_rad``, ``torque_use``. Empty where none was executed.
    trace: Dict[str, Array]


def simulate(
    plan: PathLike,
    *,
    hold: bool = True,
    execute: bool = True,
    world: str = "known",
    perturb: Union[str, Sequence[str]] = (),
    runs: int = 8,
    seed: Optional[int] = None,
    config: Optional[Config] = None,
    threads: Optional[int] = None,
) -> Simulation:
    """Holds the stances of a ``plan.json`` and executes its motion in MuJoCo, as ``scandent simulate`` does.

    ``hold`` and ``execute`` say which of both. ``world`` is what really stands there where that is known
    (``known``), ``true`` or ``planned``. ``perturb`` are what ``runs`` further executions are disturbed in: ``all``,
    or some of ``friction``, ``mass``, ``surfaces``, ``pushes``, ``sensing``, drawn from ``seed``.
    ``config`` are settings such as ``{"simulation": {"hold_push_n": 30.0}}``.

    Needs the wheel ``mujoco`` (``pip install 'scandent[simulation]'``). Raises ``InputError``.
    """
    flags = ["simulate", *options(config, seed, None, threads)]
    if not (hold or execute):
        raise InputError("execute: neither hold nor execute is wanted", "execute")
    flags += [] if execute else ["--hold"]
    flags += [] if hold else ["--execute"]
    if text(world, "world") not in _WORLDS:
        raise InputError(f"world = {world!r} is none of {', '.join(_WORLDS)}", "world")
    kinds = [perturb] if isinstance(perturb, str) else each(perturb, "perturb")
    for kind in kinds:
        if not isinstance(kind, str) or kind not in _KINDS:
            raise InputError(f"perturb holds {kind!r}, which is none of {', '.join(_KINDS)}", "perturb")
    flags += [f"--world={world}", f"--runs={whole(runs, 'runs', 1)}", *(f"--perturb={kind}" for kind in kinds)]
    flags += ["--", path(plan, "plan")]
    load_mujoco()
    said, trace, failures = _scandent.simulate(flags)
    columns: Dict[str, Array] = {}
    if trace is not None:
        names = trace.partition("\n")[0].split(",")
        rows = np.loadtxt(io.StringIO(trace), delimiter=",", skiprows=1, ndmin=2)
        columns = dict(zip(names, rows.T))
    return Simulation(not failures, failures, json.loads(said), columns)


def mjcf(plan: PathLike) -> str:
    """The robot of a ``plan.json`` in its world as the text of a model of MuJoCo's (``MjModel.from_xml_string``).

    ``qpos`` is the base's position, its quaternion w x y z, and the joints in the order of q; one servo a joint,
    in the same order, with a stiffness of 5000 N·m/rad. Raises ``InputError``.
    """
    return _scandent.mjcf(path(plan, "plan"))
