"""Data sets: plans as arrays with a card, one file each, or the folder of a batch.

An episode's file is an ``.npz`` that numpy reads alone, the same that ``scandent export --format npz`` and
``scandent batch --export npz`` write. Its ``card`` is a text of JSON that holds the whole plan.
"""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Sequence

import numpy as np
import numpy.typing as npt

from ._arguments import Array, PathLike, path
from ._errors import InputError
from ._plan import Motion, Plan, read_arrays
from ._terrain import Terrain

FORMAT = "scandent-episode/2"


@dataclass(frozen=True)
class Episode(Motion):
    """A motion with the plan that it is of."""

    #: Postures of the stances (stances, 7 + joints).
    stances_q: Array
    #: Sample at which each stance is reached (stances,).
    stances_at: npt.NDArray[np.int64]
    #: ``plan``, all that ``plan.json`` says: robot, scene, seed, settings, inputs, goal, terrain, stances with
    #: their contacts and margins, what the search did; and ``phases``.
    card: Dict[str, Any]

    @property
    def joint_names(self) -> List[str]:
        """The joints in the order of q."""
        return list(self.card["plan"]["robot"]["joint_names"])

    @property
    def terrain(self) -> Terrain:
        """What was planned on, the ground under the start included."""
        return Terrain._of(self.card["plan"], "card")


def of_plan(plan: Plan) -> Episode:
    """The episode of a plan with a motion. Raises ``InputError`` where there is none."""
    if plan.motion is None:
        raise InputError("plan has no motion", "plan")
    return _read(plan.export("npz"), "plan")


def save(plan: Plan, file: PathLike) -> None:
    """Writes the episode of a plan in one step: a reader meets the old file or the whole new one."""
    place = Path(path(file, "file"))
    if place.suffix != ".npz":
        raise InputError(f"file {place} does not end in .npz", "file")
    unfinished = place.with_name(f".{place.name}-{os.getpid()}")
    try:
        unfinished.write_bytes(plan.export("npz"))
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
        self.folders: List[Path] = [place for place in places if (place / "motion.json").exists()]

    def __len__(self) -> int:
        return len(self.folders)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        folder = self.folders[index]
        arrays = folder / "motion.npz"
        return load(arrays) if arrays.exists() else of_plan(Plan.load(folder / "plan.json"))


def load(file: PathLike) -> Any:
    """An ``Episode`` of an ``.npz``, or the ``Episodes`` of the folder of ``scandent batch``. Raises ``InputError``."""
    place = Path(path(file, "file"))
    if os.path.isdir(place):
        return Episodes(_batch(place, "file"))
    try:
        return _read(place.read_bytes(), f"file {place}")
    except OSError as error:
        raise InputError(f"file cannot be read: {error}", "file") from None


def _batch(folder: Path, argument: str) -> Path:
    if not os.path.exists(folder / "index.csv"):
        words = f"{argument} {folder} holds no index.csv: it is not the folder of a batch"
        raise InputError(words, argument)
    return folder


def _read(data: bytes, what: str) -> Episode:
    try:
        arrays, card = read_arrays(io.BytesIO(data))
        if card.get("format") != FORMAT:
            raise InputError(f"{what}: the format is {card.get('format')!r}, not {FORMAT!r}", "file")
        more = {name: arrays[name] for name in ("stances_q", "stances_at")}
        return Episode.of_arrays(arrays, card["phases"], card=card, **more)
    except InputError:
        raise
    # An archive can be broken in as many ways as its readers have exceptions.
    except Exception as error:
        raise InputError(f"{what} is no episode: {error}", "file") from None


def parquet(folder: PathLike) -> Path:
    """Writes the index of a batch as ``index.parquet`` beside the CSV (needs ``pyarrow``). Raises ``InputError``."""
    here = _batch(Path(path(folder, "folder")), "folder")
    try:
        import pyarrow as pa
        from pyarrow import csv as table, parquet as file
    except ImportError:
        raise InputError("folder: pyarrow is not installed: pip install 'scandent[parquet]'", "folder") from None
    # A column that is empty so far has its type, too.
    texts = dict.fromkeys(("item", "ended", "family", "robot", "reason"), pa.string())
    numbers = dict.fromkeys(("motion_s", "clearance_m", "torque_use", "friction_use"), pa.float64())
    types = table.ConvertOptions(column_types={**texts, **numbers, "seed": pa.int64()})
    place = here / "index.parquet"
    unfinished = place.with_name(f".{place.name}-{os.getpid()}")
    lines = table.ParseOptions(newlines_in_values=True)
    file.write_table(table.read_csv(here / "index.csv", None, lines, types), unfinished)
    os.replace(unfinished, place)
    return place
