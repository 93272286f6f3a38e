"""Plans: made, read, verified, shown."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass
from functools import cached_property
from typing import IO, TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _scandent
from ._arguments import (
    Array, Config, PathLike, each, listed, mapping, matrix, number, numbers, of, options, path, pose, text, whole, write
)
from ._errors import InputError, NoPlan, Refused, Undecided, Unsolved
from ._rerun import to_rerun
from ._robot import Robot
from ._terrain import Terrain

if TYPE_CHECKING:
    from typing_extensions import Self

#: Told ``(nodes, solved, best_distance_m, stage)``; the search stops where it returns ``False``.
Progress = Callable[[int, int, float, str], Optional[bool]]


@dataclass(frozen=True)
class Contact:
    """A patch of the robot that touches a face."""

    patch: str
    #: The link that carries it.
    link: str
    #: The face that it touches.
    face: str
    #: Pose of the patch frame C in W (4, 4), z out of the surroundings, m.
    X_WC: Array
    #: Coefficient of friction.
    friction: float
    #: Whether it may bear; one that was just made or is about to leave does not.
    loaded: bool
    #: Corners of the patch in W (n, 3), m.
    vertices_W: Array
    #: Where forces act in W (n, 3), m.
    force_points_W: Array
    #: Force on the robot at each of them in W (n, 3), N.
    forces_W: Array


@dataclass(frozen=True)
class Stance:
    """A contact set with its posture."""

    index: int
    #: What was done to come to it: ``{"kind": "add", "patch": …, "face": …}``.
    change: Dict[str, str]
    contacts: List[Contact]
    #: Base position in m, quaternion x y z w, joints in rad or m (7 + joints).
    q: Array
    #: Centre of mass in W (3,), m.
    com_W: Array
    #: How far the posture is from each limit; what is negative is violated.
    margins: Dict[str, Optional[float]]

    @property
    def forces(self) -> Dict[str, Array]:
        """Force on the robot at each force point of every patch that bears, in W (n, 3), N."""
        return {contact.patch: contact.forces_W for contact in self.contacts if contact.loaded}


@dataclass(frozen=True)
class Motion:
    """The whole body in time, sampled at equal steps.

    Joints are in the order of ``Robot.joint_names``; rates of the base are in W. For Pinocchio, which orders
    joints by name and has the base's rates in the base's axes, see ``scandent.pinocchio.trajectory``.
    """

    #: Time (n,), s.
    t: Array
    #: Base position in m, quaternion x y z w, joints in rad or m (n, 7 + joints).
    q: Array
    #: Velocity of the base's origin and its angular velocity, both in W, then joints (n, 6 + joints): m/s, rad/s.
    v: Array
    #: Its derivative (n, 6 + joints), m/s², rad/s².
    a: Array
    #: What the joints exert (n, joints), N·m or N.
    tau: Array
    #: Centre of mass in W (n, 3), m.
    com_W: Array
    #: Force and moment about the origin of each patch's frame C on the robot, in W (n, patches, 6): N, N·m; NaN
    #: where the patch is in the air.
    wrenches: Array
    #: The patches of ``wrenches``.
    patches: List[str]
    #: What is done when: ``kind``, ``t_start_s``, ``t_end_s``, ``from_stance``, ``to_stance``, ``contacts``, ``swing``.
    phases: List[Dict[str, Any]]

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, Any], phases: List[Dict[str, Any]], **more: Any) -> Self:
        """The motion of the arrays of an ``.npz`` of ``export`` and the phases of its card."""
        own = {name: arrays[name] for name in ("t", "q", "v", "a", "tau", "com_W", "wrenches")}
        return cls(**own, patches=arrays["patches"].tolist(), phases=phases, **more)

    @property
    def dt_s(self) -> float:
        """Time between two samples, s."""
        return float(self.t[1] - self.t[0]) if len(self.t) > 1 else 0.0

    @property
    def duration_s(self) -> float:
        """How long it takes, s."""
        return float(self.t[-1])

    def closed(self) -> npt.NDArray[np.bool_]:
        """Which patch touches when (n, patches)."""
        return ~np.isnan(self.wrenches[:, :, 0])


@dataclass(frozen=True)
class Certificate:
    """The verifier's verdict, recomputed by code that shares nothing with the solver."""

    passes: bool
    #: What was taken from the plan as it says.
    conditions: List[str]
    #: Every check by itself, as in ``certificate.json``.
    record: Dict[str, Any]

    @staticmethod
    def of_json(text: str) -> Certificate:
        """The certificate of a ``certificate.json``."""
        record = json.loads(text)
        return Certificate(bool(record["pass"]), list(record["conditions"]), record)


class Plan:
    """Stances from start to goal, and the motion between them."""

    def __init__(self, native: _scandent.Plan) -> None:
        self._native = native

    @staticmethod
    def load(file: PathLike) -> Plan:
        """Reads a ``plan.json``, and its motion and its robot from where it names them. Raises ``InputError``."""
        return Plan(_scandent.Plan.load(path(file, "file")))

    @cached_property
    def record(self) -> Dict[str, Any]:
        """All that ``plan.json`` says."""
        record: Dict[str, Any] = json.loads(self._native.json())
        return record

    @cached_property
    def stances(self) -> List[Stance]:
        """The stances, start first."""
        return [_stance(record) for record in self.record["stances"]]

    @cached_property
    def motion(self) -> Optional[Motion]:
        """The motion; none of a plan of one stance, or where the search did not get to it."""
        if not self._native.moves():
            return None
        arrays, card = read_arrays(io.BytesIO(self.export("npz")))
        return Motion.of_arrays(arrays, card["phases"])

    @cached_property
    def certificate(self) -> Optional[Certificate]:
        """The verdict of the verifier; none of a plan that was read: ``scandent.verify``."""
        text = self._native.certificate()
        return None if text is None else Certificate.of_json(text)

    @property
    def joint_names(self) -> List[str]:
        """The joints in the order of q."""
        return list(self.record["robot"]["joint_names"])

    @property
    def report(self) -> Dict[str, Any]:
        """Times (ms), sizes and memory of the search; empty of a plan that was read."""
        return dict(json.loads(self._native.report() or "{}"))

    @property
    def notes(self) -> List[str]:
        """What was found and assumed on the way."""
        return self._native.notes()

    def save(self, folder: PathLike) -> None:
        """Writes the folder of results that the command line writes, in one step. Raises ``InputError``."""
        self._native.save(path(folder, "folder"))

    def export(self, format: str) -> bytes:
        """The plan as ``scandent export --format`` writes it: mcc-yaml, json, csv, motion-csv, npz or mcap."""
        return self._native.export(text(format, "format"))

    def view(self, file: Optional[PathLike] = None) -> Page:
        """The page that shows the plan, offline: written to ``file`` where there is one; a notebook shows it."""
        page = Page(self._native.page())
        if file is not None:
            write(file, page.html)
        return page

    def to_rerun(self, file: Optional[PathLike] = None, application: str = "scandent") -> Any:
        """The plan as a stream of Rerun, written to ``file`` (``.rrd``) where there is one.

        Of ``world`` what may be touched, the robot's links moved along the motion (s, 20 times a second, on the timeline
        ``time``), contacts and forces; ``joints`` (rad, rad/s, Nm) and ``phase``. Returns the ``RecordingStream``, to
        ``spawn`` or ``connect`` before it is dropped. Raises ``InputError`` where ``scandent[rerun]`` is not installed.
        """
        return to_rerun(self, None if file is None else path(file, "file"), application)

    def __repr__(self) -> str:
        motion = self.record.get("motion")
        lasts = "no motion" if motion is None else f"{motion['duration_s']:.1f} s"
        return f"<Plan {self.record['scene']}: {len(self.record['stances'])} stances, {lasts}>"


@dataclass(frozen=True)
class Page:
    """A page of HTML that needs no network."""

    html: str

    def _repr_html_(self) -> str:
        inside = self.html.replace("&", "&amp;").replace('"', "&quot;")
        return f'<iframe srcdoc="{inside}" style="width:100%;height:640px;border:0"></iframe>'


def read_arrays(file: Union[str, IO[bytes]]) -> Tuple[Dict[str, Any], Dict[str, Any]]:
    """The arrays of an ``.npz`` of ``export``, and its card. Raises ``ValueError``, ``KeyError``, ``OSError``."""
    with np.load(file, allow_pickle=False) as read:
        arrays = dict(read)
    card: Dict[str, Any] = json.loads(arrays.pop("card").item())
    return arrays, card


def _stance(record: Mapping[str, Any]) -> Stance:
    contacts = [
        Contact(
            patch=c["patch"],
            link=c["link"],
            face=c["face"],
            X_WC=matrix(c["X_WC"]),
            friction=c["friction"],
            loaded=c["loaded"],
            vertices_W=_points(c.get("vertices_W")),
            force_points_W=_points(c.get("force_points_W")),
            forces_W=_points(c.get("forces_W")),
        )
        for c in record["contacts"]
    ]
    return Stance(
        index=record["index"],
        change=record["change"],
        contacts=contacts,
        q=np.array(record["q"]),
        com_W=np.array(record["com_W"]),
        margins=record["margins"],
    )


def _points(points: Optional[Sequence[Sequence[float]]]) -> Array:
    return np.array(points or [], dtype=np.float64).reshape(-1, 3)


def plan(
    terrain: Terrain,
    robot: Robot,
    start: Union[None, str, Tuple[str, npt.ArrayLike], Mapping[str, npt.ArrayLike], Stance] = None,
    goal: Optional[npt.ArrayLike] = None,
    guide: Optional[npt.ArrayLike] = None,
    *,
    start_joints: Optional[Mapping[str, float]] = None,
    start_contacts: Sequence[str] = (),
    before_floor: bool = False,
    goal_contacts: Optional[Mapping[str, Union[str, npt.ArrayLike]]] = None,
    goal_posture: Union[str, Mapping[str, float], None] = None,
    goal_tolerance_m: Optional[float] = None,
    friction: Optional[float] = None,
    config: Optional[Config] = None,
    seed: Optional[int] = None,
    improve: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[Progress] = None,
) -> Plan:
    """Plans over a terrain and verifies the plan, as ``scandent plan`` does: the same bytes.

    ``start`` is the name of a posture, upright over the origin with its soles on z = 0 (default: the resting
    one); a posture and the pose of the base in W; a mapping of patches to the poses of their frames C in W; or a
    stance of an earlier plan. Poses are matrices (4, 4), or x, y, z, qx, qy, qz, qw. ``start_joints`` are joints that
    are elsewhere than the posture has them, rad or m. ``start_contacts`` are the patches that touch the ground (all
    feet; of a stance its own). ``before_floor`` moves a start that has no pose on to just before the floor that is seen ahead of
    the origin. ``goal`` is x, y or x, y, z or x, y, z, yaw of the base in W, m and rad;
    ``goal_contacts`` are contacts that it must have, on a face or at a place (3,). ``goal_posture``
    is one of the robot's postures, or values of joints by their names, that it must have at the end. ``guide`` are
    places (n, 3) that the base should pass. ``config`` are settings as ``scandent config`` lists them, such as
    ``{"planner": {"nodes_max": 200}}``. The plan does not depend on ``threads``.

    Other threads of Python run meanwhile; Ctrl-C stops it. Raises ``NoPlan``, ``Undecided`` or ``Refused`` with
    the reasons, and ``InputError`` that names the argument.
    """
    of(terrain, Terrain, "terrain")
    of(robot, Robot, "robot")
    if not robot.patches:
        raise InputError(
            f"robot {robot.name} has no contact patches, and none could be proposed: give contacts= to Robot.load",
            "robot",
        )
    flags = ["plan", *robot._native.flags()]
    flags += _start(start, robot)
    flags += [f"--start={joint}" for joint in _joints(start_joints, robot, "start_joints")]
    if isinstance(start, Stance) and not start_contacts:
        start_contacts = [contact.patch for contact in start.contacts]
    touching = [_patch(name, robot, "start_contacts") for name in each(start_contacts, "start_contacts")]
    flags += ["--start-contacts", ",".join(touching)] if touching else []
    flags += ["--before-floor"] if before_floor else []
    wanted = mapping(goal_contacts, "goal_contacts")
    if goal is None and not wanted and goal_posture is None:
        raise InputError("goal, or goal_contacts or goal_posture, is missing", "goal")
    if goal is not None:
        place = numbers(goal, "goal", None)
        if len(place) not in (2, 3, 4):
            raise InputError(f"goal holds {len(place)} numbers, not x, y[, z[, yaw]]", "goal")
        flags += [f"--goal={listed(place)}"]
    for patch, where in wanted.items():
        at = text(where, "goal_contacts") if isinstance(where, str) else listed(numbers(where, "goal_contacts", 3))
        flags += [f"--goal-contact={_patch(patch, robot, 'goal_contacts')}={at}"]
    flags += [f"--goal-posture={wanted}" for wanted in _goal_posture(goal_posture, robot)]
    for name, value in [("goal_tolerance_m", goal_tolerance_m), ("friction", friction)]:
        if value is not None:
            if number(value, name) <= 0.0:
                raise InputError(f"{name} = {value} is not positive", name)
            flags += [f"--{name.replace('_', '-')}={float(value)!r}"]
    if guide is not None:
        flags += [f"--guide={listed(place)}" for place in numbers(guide, "guide", None, 3)]
    flags += options(config, seed, improve, threads)
    return _solved(_scandent.from_flags(terrain._native, flags, _callable(progress)))


def run(
    scene: PathLike,
    *,
    config: Optional[Config] = None,
    seed: Optional[int] = None,
    improve: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[Progress] = None,
) -> Plan:
    """Plans for a scene that ships or a ``scene.toml``, as ``scandent run`` does; else as ``plan``."""
    flags = ["plan", *options(config, seed, improve, threads)]
    return _solved(_scandent.of_scene(path(scene, "scene"), flags, _callable(progress)))


def verify(plan: PathLike, *, against: Optional[PathLike] = None, threads: Optional[int] = None) -> Certificate:
    """Recomputes everything that the ``plan.json`` promises, as ``scandent verify`` does.

    ``against`` is the scene that it must be of; without it the plan's own is looked up, and what is not found
    is named among ``conditions``. Raises ``InputError`` for a plan that cannot be read.
    """
    scene = None if against is None else path(against, "against")
    return Certificate.of_json(_scandent.check(path(plan, "plan"), scene, whole(threads, "threads", 1)))


def _solved(native: _scandent.Plan) -> Plan:
    made = Plan(native)
    unsolved = native.unsolved()
    if unsolved is None:
        return made
    status, words, reasons, to_try = unsolved
    kinds: Dict[str, type[Unsolved]] = {"no_plan": NoPlan, "refused": Refused}
    raise kinds.get(status, Undecided)(words, status, reasons, to_try, made)


def _callable(progress: Any) -> Any:
    if progress is not None and not callable(progress):
        raise InputError(f"progress is not callable but a {type(progress).__name__}", "progress")
    return progress


def _goal_posture(wanted: Union[str, Mapping[str, float], None], robot: Robot) -> List[str]:
    """A posture of the robot, or joints and their values, as flags say it."""
    if isinstance(wanted, str):
        postures = list(robot.postures)
        if wanted not in postures:
            raise InputError(f"goal_posture = {wanted!r} is no posture of {robot.name}: {postures}", "goal_posture")
        return [wanted]
    return _joints(wanted, robot, "goal_posture")


def _joints(values: Optional[Mapping[str, float]], robot: Robot, argument: str) -> List[str]:
    """JOINT=VALUE of each."""
    values = mapping(values, argument)
    for name in values:
        if name not in robot.joint_names:
            raise InputError(f"{argument}: {name!r} is no joint of {robot.name}", argument)
    return [f"{name}={number(value, argument)!r}" for name, value in values.items()]


def _patch(name: Any, robot: Robot, argument: str) -> str:
    if not isinstance(name, str) or name not in robot.patches:
        known = ", ".join(robot.patches)
        raise InputError(f"{argument}: {robot.name} has no patch {name!r}; there are {known}", argument)
    return str(name)


def _start(start: Any, robot: Robot) -> List[str]:
    if start is None:
        return []
    if isinstance(start, Stance):
        joints = dict(zip(robot.joint_names, start.q[7:]))
        if len(robot.joint_names) != len(start.q) - 7:
            raise InputError(f"start: {robot.name} has other joints than the stance", "start")
        return [f"--start=@{listed(start.q[:7])}", *(f"--start={name}" for name in _joints(joints, robot, "start"))]
    if isinstance(start, Mapping):
        poses = {_patch(name, robot, "start"): pose(at, f"start[{name!r}]") for name, at in start.items()}
        return [f"--start={name}={listed(at)}" for name, at in poses.items()]
    name, base = start if isinstance(start, (tuple, list)) and len(start) == 2 else (start, None)
    if not isinstance(name, str):
        raise InputError("start is no posture, posture with a pose, mapping of patches to poses, or stance", "start")
    if name not in robot.postures:
        known = ", ".join(robot.postures)
        raise InputError(f"start: {robot.name} has no posture {name!r}; there are {known}", "start")
    return [f"--start={name}" if base is None else f"--start={name}@{listed(pose(base, 'start'))}"]
