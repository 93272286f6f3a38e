"""Postures: of one contact set on a terrain, or of many."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _scandent
from ._arguments import Array, Config, PathLike, as_json, each, number, numbers, of, path, pose, settings, text, whole
from ._errors import InputError
from ._plan import _patch
from ._robot import Robot
from ._terrain import Terrain


@dataclass(frozen=True)
class Touch:
    """A contact that a posture is wanted for: anywhere on a face, or at a pose.

    ``pose`` is that of the patch frame C in W, z out of the surroundings: (4, 4), or x, y, z, qx, qy, qz, qw;
    of a ball the touched point. With ``face`` too, what lies behind that face may be touched.
    """

    patch: str
    face: Optional[str] = None
    pose: Optional[npt.ArrayLike] = None
    #: Whether the patch may turn about its z, at a pose.
    yaw_free: bool = False
    #: Whether it may bear.
    loaded: bool = True
    #: Coefficient of friction; the patch's own without it.
    friction: Optional[float] = None


@dataclass(frozen=True)
class Posture:
    """The answer to a posture problem: a posture, or the reason why there is none."""

    #: ``feasible``; ``infeasible`` (proved), or ``undecided``.
    outcome: str
    #: The constraint that is violated most.
    reason: Optional[str]
    #: Which constraints cannot hold together, and what it would take, where it was asked.
    explanation: Optional[str]
    #: Base position in m, quaternion x y z w, joints in rad or m (7 + joints); none where it is not feasible.
    q: Optional[Array]
    #: Where forces act, by patch, in W (n, 3), m.
    force_points_W: Dict[str, Array]
    #: Force on the robot there, by patch, in W (n, 3), N.
    forces: Dict[str, Array]
    #: How far it is from each limit.
    margins: Dict[str, Optional[float]]
    #: Iterations over all starts.
    iterations: Optional[int]

    @property
    def feasible(self) -> bool:
        """Whether there is a posture."""
        return self.outcome == "feasible"

    @staticmethod
    def _of(record: Mapping[str, Any]) -> Posture:
        forces = record["forces"] or []
        return Posture(
            outcome=record["outcome"],
            reason=record["reason"],
            explanation=record["explanation"],
            q=None if record["q"] is None else np.array(record["q"]),
            force_points_W={c["patch"]: np.array(c["points_W"]).reshape(-1, 3) for c in forces},
            forces={c["patch"]: np.array(c["forces_W"]).reshape(-1, 3) for c in forces},
            margins=record["margins"] or {},
            iterations=record["iterations"],
        )


class Postures(Sequence[Posture]):
    """The answers to many problems, in their order."""

    def __init__(self, native: _scandent.Postures) -> None:
        self._native = native
        #: ``feasible``, ``infeasible`` or ``undecided``, a problem each.
        self.outcomes: List[str] = native.outcomes
        #: Postures (n, 7 + joints), a row of NaN where there is none.
        self.q: Array = native.q()
        #: Iterations (n,), 0 where there is no posture.
        self.iterations: npt.NDArray[np.int64] = native.iterations()

    @property
    def feasible(self) -> npt.NDArray[np.bool_]:
        """Which have a posture (n,)."""
        return ~np.isnan(self.q[:, 0])

    def __len__(self) -> int:
        return len(self._native)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        at = index + len(self) if index < 0 else index
        text = self._native.json(at) if at >= 0 else None
        if text is None:
            raise IndexError(f"answer {index} of {len(self)}")
        return Posture._of(json.loads(text))


def solve_posture(
    robot: Robot,
    terrain: Terrain,
    contacts: Union[Mapping[str, Union[str, npt.ArrayLike]], Sequence[Touch]],
    *,
    reference: Optional[npt.ArrayLike] = None,
    base_goal: Optional[Sequence[Optional[float]]] = None,
    base_tolerance_m: float = 0.1,
    yaw_rad: Optional[float] = None,
    yaw_tolerance_rad: float = 0.1,
    explain: bool = False,
    config: Optional[Config] = None,
) -> Posture:
    """A posture in equilibrium on these contacts, inside every margin, or the reason why there is none.

    ``contacts`` maps patches to the face that each is to be anywhere on, or to a pose; or they are ``Touch``es.
    ``reference`` is q (7 + joints): where it starts and what it stays near to (default: the resting posture
    over the contacts). ``base_goal`` is x, y, z of the base in W, ``None`` where it is free, met within
    ``base_tolerance_m``, and ``yaw_rad`` its heading. ``explain`` finds the constraints that cannot hold
    together. That there is no posture is an answer; ``InputError`` names an argument that makes no sense.
    """
    of(robot, Robot, "robot")
    of(terrain, Terrain, "terrain")
    if isinstance(contacts, Mapping):
        contacts = [
            Touch(patch, face=where) if isinstance(where, str) else Touch(patch, pose=where)
            for patch, where in contacts.items()
        ]
    wanted = [_wanted(touch, robot, f"contacts[{i}]") for i, touch in enumerate(each(contacts, "contacts"))]
    if not wanted:
        raise InputError("contacts is empty: nothing would hold the robot", "contacts")
    near = None
    if reference is not None:
        near = numbers(reference, "reference", 7 + len(robot.joint_names)).tolist()
    base = None
    if base_goal is not None or yaw_rad is not None:
        place = [None, None, None] if base_goal is None else each(base_goal, "base_goal")
        if len(place) != 3:
            raise InputError(f"base_goal holds {len(place)} values, not 3", "base_goal")
        at = [None if x is None else number(x, "base_goal") for x in place]
        yaw = None if yaw_rad is None else number(yaw_rad, "yaw_rad")
        base = (at, number(base_tolerance_m, "base_tolerance_m"), yaw, number(yaw_tolerance_rad, "yaw_tolerance_rad"))
    solved = _scandent.solve(robot._native, terrain._native, wanted, near, base, bool(explain), settings(config))
    return Posture._of(json.loads(solved))


def _wanted(touch: Any, robot: Robot, argument: str) -> _scandent.Wanted:
    of(touch, Touch, argument)
    face = None if touch.face is None else text(touch.face, argument)
    at = None if touch.pose is None else pose(touch.pose, argument)
    if at is None and touch.face is None:
        raise InputError(f"{argument} has neither a face nor a pose", "contacts")
    friction = None if touch.friction is None else number(touch.friction, argument)
    patch = _patch(touch.patch, robot, argument)
    return (patch, face, at, bool(touch.yaw_free), bool(touch.loaded), friction)


def solve_postures(
    robot: Robot,
    problems: Union[PathLike, bytes, Sequence[Mapping[str, Any]], Mapping[str, Any]],
    *,
    reference: Optional[str] = None,
    config: Optional[Config] = None,
    threads: Optional[int] = None,
) -> Postures:
    """Solves independent posture problems on all cores, as ``scandent posture`` does.

    ``problems`` are a file, its bytes, or what it holds (docs/formats.md). ``reference`` names the posture to
    stay near to. Ctrl-C stops it. Raises ``InputError``.
    """
    of(robot, Robot, "robot")
    near = None if reference is None else text(reference, "reference")
    if isinstance(problems, (Mapping, list, tuple)):
        data = as_json(problems, "problems").encode()
    elif isinstance(problems, bytes):
        data = problems
    else:
        file = path(problems, "problems")  # type: ignore[arg-type]
        try:
            with open(file, "rb") as read:
                data = read.read()
        except OSError as error:
            raise InputError(f"problems: {error}", "problems") from None
    count = whole(threads, "threads", 1)
    return Postures(_scandent.solve_all(robot._native, data, near, settings(config), count))


def draw_postures(robot: Robot, family: str, count: int, *, seed: int = 0, config: Optional[Config] = None) -> bytes:
    """Posture problems drawn from a seed, as ``scandent posture-sets`` writes them.

    ``family`` is easy, free, steep, one-foot, chimney, spread, infeasible, or hard. Raises ``InputError``.
    """
    of(robot, Robot, "robot")
    number_of = whole(count, "count", 1) or 1
    drawn = _scandent.draw(robot._native, text(family, "family"), number_of, whole(seed, "seed") or 0, settings(config))
    return drawn.encode()
