"""Every example runs; so do the batch's."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import scandent
from conftest import ROOT

EXAMPLES = ROOT / "python" / "examples"
HEXAPOD = ROOT / "scenes" / "robots" / "hexapod"
ARGUMENTS = {
    "scan_to_plan": ["out"],
    "own_robot": [],
    "posture_checked_by_pinocchio": [str(HEXAPOD / name) for name in ("hexapod.urdf", "hexapod.srdf", "contacts.toml")],
    "margins": [],
    "batch": ["out", "2"],
}


def test_every_example_is_run() -> None:
    assert sorted(p.stem for p in EXAMPLES.glob("*.py")) == sorted(ARGUMENTS)


@pytest.mark.parametrize("name", ARGUMENTS)
def test_example(name: str, tmp_path: Path) -> None:
    if name.endswith("pinocchio") and importlib.util.find_spec("pinocchio") is None:
        pytest.skip("SKIPPED: no pinocchio (pip install pin)")
    command = [sys.executable, str(EXAMPLES / f"{name}.py"), *ARGUMENTS[name]]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout


def items() -> list[dict[str, object]]:
    ramp = {"family": "ramp", "robot": "builtin:quadruped"}
    return [
        {"item": "a", "world_seed": 1, **ramp},
        {"item": "no-such-scene", "scene": "none", "goal": [1, 0]},
        {"item": "b", "world_seed": 2, **ramp},
        {"item": "few-nodes", "world_seed": 3, "set": {"planner.nodes_max": 2}, **ramp},
    ]


def files(folder: Path) -> dict[str, bytes]:
    """All of a batch that does not hold times."""
    found = {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    return {name: data for name, data in found.items() if Path(name).name not in ("item.json", "report.json")}


def test_batches_are_the_same_wherever_they_run(program_file: str, tmp_path: Path) -> None:
    rows = scandent.batch(items(), tmp_path / "threads", npz=True)
    assert [row["ended"] for row in rows] == ["solved", "error", "solved", "budget-spent"]
    assert "none" in rows[1]["reason"]
    with ThreadPoolExecutor(1) as one:
        scandent.batch(reversed(items()), tmp_path / "reversed", executor=one, npz=True)
    wanted = files(tmp_path / "threads")
    other = files(tmp_path / "reversed")
    same = [name for name in wanted if name not in ("manifest.jsonl", "index.csv")]
    assert same and all(other[name] == wanted[name] for name in same)

    # The program.
    manifest = tmp_path / "threads" / "manifest.jsonl"
    command = [program_file, "batch", str(manifest), "-o", "program", "--export", "npz"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    theirs = files(tmp_path / "program")
    assert {name: data for name, data in wanted.items() if name != "manifest.jsonl"} == theirs

    episodes = scandent.datasets.load(tmp_path / "program")
    assert len(episodes) == 2 and episodes[0].card["outcome"] == "verified"
    arrays = np.load(tmp_path / "program" / "items" / "a" / "motion.npz")
    assert np.array_equal(arrays["q"], episodes[0].q)
    assert np.array_equal(arrays["wrenches"], episodes[0].wrenches, equal_nan=True)
    assert arrays["joint_names"].tolist() == episodes[0].joint_names
    for folder in episodes.folders:
        certificate = scandent.verify(folder / "plan.json")
        assert certificate.passes and certificate.conditions == []
