"""Whatever is given for an argument: an answer, or an exception of ours that names it; never another, never an abort."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import scandent
from conftest import rectangle

#: So many fresh examples of each; the same few without it.
MANY = int(os.environ.get("SCANDENT_FUZZ", "0"))
WORDS = ["all", "floor", "left_foot", "half_sitting", "builtin:hrp2", "..", "-x", "--help", "\0", "\ud800", "xtion", "a\nb"]
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.text(max_size=8),
    st.binary(max_size=8),
    st.sampled_from(WORDS),
)
SHAPES = hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=7)
ARRAYS = st.one_of(
    hnp.arrays(hnp.scalar_dtypes(), SHAPES),
    hnp.arrays(np.float64, st.sampled_from([(2,), (3,), (4,), (7,), (3, 3), (4, 4), (5, 3), (35,)])),
    hnp.arrays(np.uint16, st.tuples(st.integers(0, 30), st.integers(0, 30))),
)
KEYS = st.one_of(SCALARS, st.sampled_from(["left_foot", "right_foot", "planner", "planner.nodes_max", "item", "family"]))
JUNK: st.SearchStrategy[Any] = st.recursive(
    st.one_of(SCALARS, ARRAYS, st.builds(object)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.tuples(inner, inner), st.dictionaries(KEYS, inner, max_size=3)
    ),
    max_leaves=6,
)
SQUARE = rectangle(-0.5, 0.5, 0.0)


def calls(robot: scandent.Robot, terrain: scandent.Terrain, folder: Path) -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Functions with arguments that make sense; what is computed is little."""
    short = {"planner.nodes_max": 1}
    depth = np.full((12, 16), 2000, dtype=np.uint16)
    pose = [0.0, 0.0, 1.0, -0.5, 0.5, -0.5, 0.5]
    at: dict[str, Any] = {"robot": robot, "terrain": terrain}
    plan = folder / "plan.json"
    return {
        "perceive": (
            scandent.perceive,
            {"depth": depth, "K": [15.0, 15.0, 7.5, 5.5], "T_WV": pose, "sensor": None, "depth_scale_m": None, "config": None},
        ),
        "from_mesh": (scandent.Terrain.from_mesh, {"mesh": SQUARE, "triangles": [[0, 1, 2], [0, 2, 3]], "config": None}),
        "from_polygons": (scandent.Terrain.from_polygons, {"polygons": [SQUARE], "obstacles": None, "friction": None}),
        "with_friction": (terrain.with_friction, {"friction": 0.5}),
        "load_terrain": (scandent.Terrain.load, {"file": folder / "none"}),
        "face": (terrain.face, {"name": "floor"}),
        "save_terrain": (terrain.save, {"file": folder / "none" / "surfaces.json"}),
        "load_robot": (
            scandent.Robot.load,
            {"urdf": "builtin:quadruped", "srdf": None, "contacts": None, "packages": (), "config": None},
        ),
        "solve_posture": (
            scandent.solve_posture,
            {
                **at,
                "contacts": {"left_foot": "floor"},
                "reference": None,
                "base_goal": None,
                "base_tolerance_m": 0.1,
                "yaw_rad": None,
                "yaw_tolerance_rad": 0.1,
                "config": {"posture.starts": 1},
            },
        ),
        "solve_postures": (
            scandent.solve_postures,
            {"robot": robot, "problems": b"{}", "reference": None, "config": None, "threads": 1},
        ),
        "draw_postures": (
            scandent.draw_postures,
            {"robot": robot, "family": "easy", "count": 1, "seed": 1, "config": None},
        ),
        "plan": (
            scandent.plan,
            {
                **at,
                "start": "half_sitting",
                "goal": [0.2, 0.0],
                "guide": None,
                "start_joints": None,
                "start_contacts": (),
                "goal_contacts": None,
                "goal_posture": None,
                "goal_tolerance_m": None,
                "friction": None,
                "config": short,
                "seed": None,
                "improve": None,
                "threads": 1,
                "progress": None,
            },
        ),
        "run": (
            scandent.run,
            {"scene": folder / "none", "config": short, "seed": 1, "improve": None, "threads": 1, "progress": None},
        ),
        "verify": (scandent.verify, {"plan": plan, "against": None, "threads": 1}),
        "load_plan": (scandent.Plan.load, {"file": plan}),
        "simulate": (
            scandent.simulate,
            {"plan": folder / "none", "world": "known", "perturb": (), "runs": 1, "seed": 1, "config": None, "threads": 1},
        ),
        "mjcf": (scandent.mjcf, {"plan": folder / "none"}),
        "batch": (
            scandent.batch,
            {"items": [{"item": "a", "scene": "none"}], "folder": folder / "batch", "executor": None, "progress": None},
        ),
        "load_episode": (scandent.datasets.load, {"file": folder / "none"}),
        "parquet": (scandent.datasets.parquet, {"folder": folder / "none"}),
    }


NAMED = ["perceive", "from_mesh", "from_polygons", "with_friction", "load_terrain", "face", "save_terrain", "load_robot"]
NAMED += ["solve_posture", "solve_postures", "draw_postures", "plan", "run", "verify", "load_plan", "simulate", "mjcf", "batch"]
NAMED += ["load_episode", "parquet"]


@pytest.mark.parametrize("name", NAMED)
@settings(
    max_examples=MANY or 60,
    deadline=None,
    derandomize=not MANY,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(data=st.data())
def test_any_argument_is_answered_or_named(
    name: str, data: st.DataObject, hrp2: scandent.Robot, step: scandent.Terrain, tmp_path: Path
) -> None:
    function, sense = calls(hrp2, step, tmp_path)[name]
    argument = data.draw(st.sampled_from(sorted(sense)))
    junk = data.draw(JUNK)
    # What names a place to write in is not written to.
    if argument in ("folder", "file") and name in ("batch", "save_terrain") and isinstance(junk, (str, bytes)):
        return
    try:
        function(**{**sense, argument: junk})
    except scandent.InputError as error:
        others = {"problems", "polygons", "mesh", "config", "contacts", "items", None}
        blamed = error.argument
        assert blamed is None or blamed.partition("[")[0] in {argument, *sense, *others}, (argument, junk, error)
        assert "mistake in scandent" not in str(error)
    except scandent.Unsolved:
        pass


@settings(max_examples=MANY or 200, deadline=None, derandomize=not MANY, database=None)
@given(data=st.binary(max_size=400))
def test_any_bytes_are_refused_as_files(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("files")
    readers: dict[str, Callable[[Path], object]] = {
        "json": scandent.Plan.load,
        "surfaces": scandent.Terrain.load,
        "obj": scandent.Terrain.from_mesh,
        "urdf": scandent.Robot.load,
        "npz": scandent.datasets.load,
    }
    for suffix, read in readers.items():
        file = folder / f"any.{suffix}"
        file.write_bytes(data)
        with pytest.raises(scandent.InputError):
            read(file)
