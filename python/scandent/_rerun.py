"""A plan as a recording of Rerun, from the one that ``export("mcap")`` gives Foxglove."""

from __future__ import annotations

import io
import json
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional

import numpy as np

from ._arguments import PathLike
from ._errors import InputError

if TYPE_CHECKING:
    from ._plan import Plan

#: Entities of the recording, and Rerun's archetype of each.
SHAPES = ("cubes", "spheres", "cylinders", "triangles", "lines", "arrows")


def to_rerun(plan: Plan, file: Optional[PathLike], application: str) -> Any:
    try:
        import rerun as rr
        from mcap.reader import make_reader
    except ImportError:
        raise InputError("to_rerun: Rerun or mcap is not installed: pip install 'scandent[rerun]'", "file") from None

    stream = rr.RecordingStream(application)
    if file is not None:
        stream.save(str(file))
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    paths = {"world": "world"}
    robot: List[Any] = []
    for _, channel, message in make_reader(io.BytesIO(plan.export("mcap"))).iter_messages():
        value, topic = json.loads(message.data), channel.topic
        stream.set_time("time", duration=message.log_time * 1e-9)
        if topic == "/tf":
            for moved in value["transforms"]:
                child = moved["child_frame_id"]
                paths[child] = f"{paths[moved['parent_frame_id']]}/{child}"
                turn = rr.Quaternion(xyzw=_wxyz(moved["rotation"])[[1, 2, 3, 0]])
                stream.log(paths[child], rr.Transform3D(translation=_xyz(moved["translation"]), quaternion=turn))
            # Links have their places with the first transforms.
            for entity in robot:
                _shapes(rr, stream, f"{paths[entity['frame_id']]}/shape", entity, static=True)
            robot = []
        elif topic == "/robot":
            robot = value["entities"]
        elif topic in ("/world", "/contacts"):
            for entity in value["entities"]:
                _shapes(rr, stream, f"world{topic}/{entity['id']}", entity, static=topic == "/world")
        elif topic == "/joint_states":
            for quantity in ("position", "velocity", "effort"):
                stream.log(f"joints/{quantity}", rr.Scalars(value[quantity]))
        elif topic == "/phase":
            said = f"{value['from_stance']} to {value['to_stance']}: {value['kind']} {value['swing']}"
            stream.log("phase", rr.TextLog(said.strip()))
    stream.flush()
    return stream


def _xyz(value: Mapping[str, float]) -> Any:
    return np.array([value["x"], value["y"], value["z"]])


def _wxyz(value: Mapping[str, float]) -> Any:
    return np.array([value["w"], value["x"], value["y"], value["z"]])


def _turned(pose: Mapping[str, Any], points: Any) -> Any:
    """Points (n, 3) of a pose's frame in the frame that the pose is in."""
    w, v = _wxyz(pose["orientation"])[0], _wxyz(pose["orientation"])[1:]
    t = 2 * np.cross(v, points)
    return points + w * t + np.cross(v, t) + _xyz(pose["position"])


def _shapes(rr: Any, stream: Any, path: str, entity: Mapping[str, Any], static: bool) -> None:
    """The shapes of an entity of Foxglove's scene; of what is not there any more, nothing."""
    for kind in SHAPES:
        shapes: List[Dict[str, Any]] = entity[kind]
        if not shapes:
            if not static:
                stream.log(f"{path}/{kind}", rr.Clear(recursive=False))
            continue
        more: Dict[str, Any] = {"colors": [[one["color"][c] for c in "rgba"] for one in shapes]}
        if kind in ("cubes", "spheres", "cylinders"):
            more["centers"] = [_xyz(one["pose"]["position"]) for one in shapes]
            more["quaternions"] = [_wxyz(one["pose"]["orientation"])[[1, 2, 3, 0]] for one in shapes]
            sizes = np.array([_xyz(one["size"]) for one in shapes])
        if kind == "cubes":
            shown = rr.Boxes3D(half_sizes=sizes / 2, fill_mode="solid", **more)
        elif kind == "spheres":
            shown = rr.Ellipsoids3D(half_sizes=sizes / 2, fill_mode="solid", **more)
        elif kind == "cylinders":
            shown = rr.Cylinders3D(lengths=sizes[:, 2], radii=sizes[:, 0] / 2, fill_mode="solid", **more)
        elif kind == "arrows":
            lengths = [one["shaft_length"] + one["head_length"] for one in shapes]
            ends = [_turned(one["pose"], np.array([[0, 0, 0], [length, 0, 0]])) for one, length in zip(shapes, lengths)]
            shown = rr.Arrows3D(origins=[e[0] for e in ends], vectors=[e[1] - e[0] for e in ends], **more)
        else:
            points = [_turned(one["pose"], np.array([_xyz(p) for p in one["points"]])) for one in shapes]
            if kind == "lines":
                closed = [np.vstack([p, p[:1]]) if one["type"] == 1 else p for one, p in zip(shapes, points)]
                shown = rr.LineStrips3D(closed, **more)
            else:
                starts = np.cumsum([0, *map(len, points[:-1])])
                corners = [np.array(one["indices"]).reshape(-1, 3) + s for one, s in zip(shapes, starts)]
                each = [c for c, p in zip(more["colors"], points) for _ in p]
                shown = rr.Mesh3D(vertex_positions=np.vstack(points), triangle_indices=np.vstack(corners), vertex_colors=each)
        stream.log(f"{path}/{kind}", shown, static=static)
