"""Data sets: plans as arrays with a card, one file each, or the folder of a batch.

An episode's file is an ``.npz`` that numpy reads alone. Its ``card`` is a JSON text that says what the arrays
are, and holds robot, scene, seed, settings, goal, terrain, route, phases and outcome.
"""

from __future__ import annotations

import csv
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Sequence

import numpy as np
import numpy.typing as npt

from ._arguments import Array, PathLike, path
from ._errors import InputError
from ._plan import Plan
from ._terrain import Terrain

FORMAT = "scandent-episode/1"

#: What the arrays are.
ARRAYS = {
    "t": "time (n,), s",
    "q": "base position, quaternion x y z w, joints (n, 7 + joints), m and rad",
    "v": "velocity of the base's origin and its angular velocity in W, joints (n, 6 + joints), m/s and rad/s",
    "a": "derivative of v (n, 6 + joints)",
    "tau": "torques of the joints (n, joints), N·m",
    "com_W": "centre of mass in W (n, 3), m",
    "wrenches": "force and moment about the origin of each patch in W (n, patches, 6), N and N·m; NaN in the air",
    "stances_q": "postures of the stances (stances, 7 + joints)",
    "stances_at": "sample at which each stance is reached (stances,)",
}


@dataclass(frozen=True)
class Episode:
    """A plan as arrays; see ``ARRAYS``."""

    t: Array
    q: Array
    v: Array
    a: Array
    tau: Array
    com_W: Array
    wrenches: Array
    stances_q: Array
    stances_at: npt.NDArray[np.int64]
    #: What they are of: ``robot``, ``joint_names``, ``patches``, ``scene``, ``seed``, ``config``, ``goal``,
    #: ``terrain``, ``route``, ``phases``, ``outcome``, ``margins``.
    card: Dict[str, Any]

    @property
    def joint_names(self) -> List[str]:
        """The joints in the order of q."""
        return list(self.card["joint_names"])

    @property
    def patches(self) -> List[str]:
        """The patches of ``wrenches``."""
        return list(self.card["patches"])

    @property
    def closed(self) -> npt.NDArray[np.bool_]:
        """The contact schedule: which patch touches when (n, patches)."""
        return ~np.isnan(self.wrenches[:, :, 0])

    @property
    def terrain(self) -> Terrain:
        """What was planned on, the ground under the start included."""
        from . import _scandent

        return Terrain(_scandent.Terrain.json(json.dumps(self.card["terrain"]), "card"))


def of_plan(plan: Plan) -> Episode:
    """The episode of a plan with a motion. Raises ``InputError`` where there is none."""
    record, motion = plan.record, plan.motion
    if motion is None:
        raise InputError("plan has no motion", "plan")
    arrives = [0.0] * len(plan.stances)
    for phase in motion.phases:
        arrives[phase["to_stance"]] = phase["t_end_s"]
    card = {
        "format": FORMAT,
        "arrays": ARRAYS,
        "program": record["program"],
        "scene": record["scene"],
        "seed": record["seed"],
        "robot": record["robot"]["name"],
        "joint_names": record["robot"]["joint_names"],
        "patches": motion.patches,
        "inputs": record["inputs"],
        "config": record["config"],
        "goal": record["goal"],
        "required": record["required"],
        "terrain": {"format": "scandent-surfaces/2", "faces": record["faces"], "obstacles": record["obstacles"]},
        "route": record["search"].get("route", []),
        "phases": motion.phases,
        "changes": [stance.change for stance in plan.stances],
        "margins": [stance.margins for stance in plan.stances],
        "outcome": record["search"].get("unsolved", {"status": "verified"})["status"],
    }
    return Episode(
        t=motion.t,
        q=motion.q,
        v=motion.v,
        a=motion.a,
        tau=motion.tau,
        com_W=motion.com_W,
        wrenches=motion.wrenches,
        stances_q=np.array([stance.q for stance in plan.stances]),
        stances_at=np.searchsorted(motion.t, np.array(arrives) - 0.5 * motion.dt_s),
        card=card,
    )


def save(episode: Episode, file: PathLike) -> None:
    """Writes an episode in one step: a reader meets the old file or the whole new one."""
    place = Path(path(file, "file"))
    if place.suffix != ".npz":
        raise InputError(f"file {place} does not end in .npz", "file")
    unfinished = place.with_name(f".{place.name}-{os.getpid()}.npz")
    arrays: Dict[str, Any] = {name: getattr(episode, name) for name in ARRAYS}
    try:
        np.savez_compressed(unfinished, card=np.array(json.dumps(episode.card)), **arrays)
        os.replace(unfinished, place)
    finally:
        unfinished.unlink(missing_ok=True)


class Episodes(Sequence[Episode]):
    """The episodes of a batch's folder, each read when it is asked for."""

    def __init__(self, folder: Path) -> None:
        with open(folder / "index.csv", newline="", encoding="utf-8") as read:
            #: The index, a row an item.
            self.rows: List[Dict[str, str]] = list(csv.DictReader(read))
        solved = [row["item"] for row in self.rows if row["ended"] == "solved"]
        places = [folder / "items" / name for name in solved]
        #: The folders of the items that have a motion.
        self.folders: List[Path] = [
            place for place in places if (place / "motion.json").exists()
        ]

    def __len__(self) -> int:
        return len(self.folders)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        return of_plan(Plan.load(self.folders[index] / "plan.json"))


def load(file: PathLike) -> Any:
    """An ``Episode`` of an ``.npz``, or the ``Episodes`` of the folder of ``scandent batch``. Raises ``InputError``."""
    place = Path(path(file, "file"))
    if not place.exists():
        raise InputError(f"file {place} does not exist", "file")
    if place.is_dir():
        if not (place / "index.csv").exists():
            raise InputError(f"file {place} holds no index.csv: it is not the folder of a batch", "file")
        return Episodes(place)
    return _read(place)


def _read(place: Path) -> Episode:
    try:
        with np.load(place, allow_pickle=False) as read:
            card = json.loads(str(read["card"]))
            if card.get("format") != FORMAT:
                raise InputError(f"file {place}: the format is {card.get('format')!r}, not {FORMAT!r}", "file")
            return Episode(card=card, **{name: read[name] for name in ARRAYS})
    except (OSError, ValueError, KeyError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"file {place} is no episode: {error}", "file") from None
