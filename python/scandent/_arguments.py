"""Arguments checked and brought into the form of the native half; what is wrong is named."""

from __future__ import annotations

import json
import os
from typing import Any, Iterable, List, Mapping, Optional, Sequence, Tuple, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

from ._errors import InputError

Array = npt.NDArray[np.float64]
PathLike = Union[str, "os.PathLike[str]"]
Config = Mapping[str, Any]
_Kind = TypeVar("_Kind")

#: How far a written rotation may be from one, and a written quaternion from length 1.
_ROTATION_TOLERANCE = 1e-4
_UNIT_TOLERANCE = 1e-3


def of(value: Any, kind: Type[_Kind], argument: str) -> _Kind:
    """A value of that kind."""
    if not isinstance(value, kind):
        raise InputError(f"{argument} is no {kind.__name__} but a {type(value).__name__}", argument)
    return value


def mapping(value: Any, argument: str) -> Mapping[Any, Any]:
    """A mapping; of nothing an empty one."""
    if value is not None and not isinstance(value, Mapping):
        raise InputError(f"{argument} is no mapping but a {type(value).__name__}", argument)
    return value or {}


def text(value: Any, argument: str) -> str:
    """A text that can be written."""
    said = of(value, str, argument)
    if "\0" in said or any("\ud800" <= c <= "\udfff" for c in said):
        raise InputError(f"{argument} = {said!r} holds what is no letter", argument)
    return said


def path(value: PathLike, argument: str) -> str:
    """A path as text."""
    try:
        return text(os.fsdecode(value), argument)
    except TypeError:
        raise InputError(f"{argument} is no path but a {type(value).__name__}", argument) from None


def each(value: Any, argument: str) -> List[Any]:
    """What a list, or whatever else can be gone through, holds; a text is none."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        raise InputError(f"{argument} is no list but a {type(value).__name__}", argument)
    try:
        return list(value)
    except TypeError as error:
        raise InputError(f"{argument} is no list: {error}", argument) from None


def as_json(value: Any, argument: str) -> str:
    """A value as JSON; numpy's numbers are numbers."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.generic):
            return value.item()
        raise TypeError(f"it holds a {type(value).__name__}")

    try:
        return json.dumps(value, allow_nan=False, default=plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"{argument} cannot be written as JSON: {error}", argument) from None


def numbers(value: Any, argument: str, *shape: Optional[int]) -> Array:
    """Finite numbers in a shape; ``None`` stands for any length."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{argument} holds what are no numbers", argument) from None
    fits = array.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, array.shape))
    if not fits:
        wanted = " x ".join("n" if n is None else str(n) for n in shape) or "one number"
        raise InputError(f"{argument} has the shape {array.shape}, not {wanted}", argument)
    if not np.isfinite(array).all():
        raise InputError(f"{argument} holds a number that is not finite", argument)
    return array


def dimensions(value: Any, argument: str) -> int:
    """How many dimensions an array has."""
    try:
        return np.ndim(value)
    except ValueError:
        raise InputError(f"{argument} holds rows that are not equally long", argument) from None


def number(value: Any, argument: str) -> float:
    """One finite number."""
    return float(numbers(value, argument))


def whole(value: Optional[int], argument: str, least: int = 0) -> Optional[int]:
    """A whole number of ``least`` or more, or nothing."""
    if value is None:
        return None
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not is_whole or not least <= value < 2**53:
        raise InputError(f"{argument} = {value!r} is no whole number from {least} on", argument)
    return int(value)


def pose(value: Any, argument: str) -> Tuple[float, ...]:
    """A pose as x, y, z, qx, qy, qz, qw: those seven, or a matrix of 4 x 4 that moves points."""
    if dimensions(value, argument) == 1:
        seven = numbers(value, argument, 7)
        length = float(np.linalg.norm(seven[3:]))
        if abs(length - 1.0) > _UNIT_TOLERANCE:
            raise InputError(f"{argument} is no pose: its quaternion has length {length:.6g}, not 1", argument)
        return tuple(seven.tolist())
    T = numbers(value, argument, 4, 4)
    R = T[:3, :3]
    off = float(np.abs(R.T @ R - np.eye(3)).max())
    if off > _ROTATION_TOLERANCE:
        raise InputError(
            f"{argument} is no pose: its rotation R has RᵀR off the identity by {off:.1e}", argument
        )
    if np.linalg.det(R) < 0.0:
        raise InputError(f"{argument} is no pose: its rotation mirrors (determinant -1)", argument)
    if np.abs(T[3] - [0.0, 0.0, 0.0, 1.0]).max() > _ROTATION_TOLERANCE:
        raise InputError(f"{argument} is no pose: its last row is {T[3].tolist()}, not [0, 0, 0, 1]", argument)
    return (*T[:3, 3].tolist(), *quaternion(R).tolist())


def quaternion(R: Array) -> Array:
    """The quaternion x, y, z, w of a rotation, w not negative, by its largest component (Shepperd)."""
    x, y, z = R[0, 0], R[1, 1], R[2, 2]
    squares = np.array([x - y - z, y - x - z, z - x - y, x + y + z]) + 1.0
    antis = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    k = int(np.argmax(squares))
    if k == 3:
        q = np.array([*antis, squares[3]])
    else:
        q = np.array([R[k, 0] + R[0, k], R[k, 1] + R[1, k], R[k, 2] + R[2, k], antis[k]])
        q[k] = squares[k]
    return np.asarray(q / np.copysign(np.linalg.norm(q), q[3]))


def matrix(pose_record: Mapping[str, Sequence[float]]) -> Array:
    """A pose of a file as a matrix of 4 x 4."""
    x, y, z, w = pose_record["quat_xyzw"]
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = pose_record["p"]
    return T


def settings(config: Optional[Config], argument: str = "config") -> List[str]:
    """Settings as ``--set`` takes them: ``{"planner": {"nodes_max": 200}}`` or ``{"planner.nodes_max": 200}``."""
    found: List[str] = []

    def walk(table: Mapping[str, Any], above: str) -> None:
        for key, value in table.items():
            name = above + text(key, argument)
            if isinstance(value, Mapping):
                walk(value, f"{name}.")
            else:
                found.append(f"{name}={as_json(value, argument)}")

    walk(mapping(config, argument), "")
    return found


def write(file: PathLike, said: str) -> None:
    """Writes a text. Raises ``InputError`` where it cannot be."""
    try:
        with open(path(file, "file"), "w", encoding="utf-8") as out:
            out.write(said)
    except OSError as error:
        raise InputError(f"file cannot be written: {error}", "file") from None


def options(
    config: Optional[Config], seed: Optional[int], improve: Optional[int], threads: Optional[int]
) -> List[str]:
    """What every command has, as its flags."""
    counts = {
        "seed": whole(seed, "seed"),
        "improve": whole(improve, "improve"),
        "threads": whole(threads, "threads", 1),
    }
    flags = [flag for one in settings(config) for flag in ("--set", one)]
    return flags + [f"--{name}={count}" for name, count in counts.items() if count is not None]


def listed(values: Iterable[float]) -> str:
    """Numbers as the command line takes them, to the last bit."""
    return ",".join(repr(float(value)) for value in values)
