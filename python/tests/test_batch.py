"""Batches: the same files wherever they run, and whatever dies."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scandent

RAMP = {"family": "ramp", "robot": "builtin:quadruped"}


def items() -> list[dict[str, object]]:
    return [
        {"item": "a", "world_seed": 1, **RAMP},
        {"item": "no-such-scene", "scene": "none", "goal": [1, 0]},
        {"item": "b", "world_seed": 2, **RAMP},
        {"item": "few-nodes", "world_seed": 3, "set": {"planner.nodes_max": 2}, **RAMP},
    ]


def files(folder: Path) -> dict[str, bytes]:
    """All of a batch that does not hold times."""
    found = {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    timed = ("item.json", "report.json", ".index.lock", "manifest.jsonl", "index.parquet")
    return {name: data for name, data in found.items() if Path(name).name not in timed}


@pytest.fixture(scope="module")
def threads(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The batch on threads."""
    folder = tmp_path_factory.mktemp("threads")
    rows = scandent.batch(items(), folder, npz=True)
    assert [row["ended"] for row in rows] == ["solved", "error", "solved", "budget-spent"]
    assert "none" in rows[1]["reason"]
    return folder


def test_processes_and_another_order(threads: Path, tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as one:
        scandent.batch(reversed(items()), tmp_path / "reversed", executor=one, npz=True)
    with ProcessPoolExecutor(2) as two:
        scandent.batch(items(), tmp_path / "processes", executor=two, npz=True)
    wanted, other = files(threads), files(tmp_path / "reversed")
    assert files(tmp_path / "processes") == wanted
    assert wanted.pop("index.csv") != other.pop("index.csv")
    assert wanted == other


def test_ray(threads: Path, tmp_path: Path) -> None:
    ray = pytest.importorskip("ray", reason="SKIPPED: no ray (pip install ray)")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        scandent.batch(items(), tmp_path / "ray", executor="ray", npz=True)
        assert files(tmp_path / "ray") == files(threads)

        # An actor that dies is started again, and what it had in hand is done.
        def kill(row: dict[str, Any]) -> None:
            if row["world"] == "a":
                actors = subprocess.run(["pgrep", "-f", "ray::_Actor"], capture_output=True, text=True, check=False)
                mine = [int(pid) for pid in actors.stdout.split() if _descends(int(pid))]
                assert mine
                os.kill(mine[0], signal.SIGKILL)

        scandent.batch(items(), tmp_path / "killed", executor="ray", npz=True, progress=kill)
        assert files(tmp_path / "killed") == files(threads)
    finally:
        ray.shutdown()


def _descends(pid: int) -> bool:
    """Whether a process was started, by whatever way, by this one."""
    while pid > 1:
        if pid == os.getpid():
            return True
        pid = int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
    return False


def test_shards_of_the_program(threads: Path, program_file: str, tmp_path: Path) -> None:
    manifest = str(threads / "manifest.jsonl")
    for shards in (1, 2, 4):
        for shard in range(1, shards + 1):
            command = [program_file, "batch", manifest, "-o", str(shards), "--export", "npz", "--shard", f"{shard}/{shards}"]
            done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
            assert done.returncode in (0, 1), done.stderr
        assert files(tmp_path / str(shards)) == files(threads)


WORKER = """
import json, sys, scandent
scandent.batch(json.load(sys.stdin), sys.argv[1], npz=True)
"""


def test_kills_lose_nothing_that_was_finished(threads: Path, tmp_path: Path) -> None:
    rng, folder, kept = random.Random(7), tmp_path / "killed", dict[str, int]()
    kills = int(os.environ.get("SCANDENT_KILLS", "6"))
    while True:
        worker = subprocess.Popen(
            [sys.executable, "-c", WORKER, str(folder)], stdin=subprocess.PIPE, start_new_session=True, text=True
        )
        assert worker.stdin is not None
        worker.stdin.write(json.dumps(items()))
        worker.stdin.close()
        if kills > 0:
            try:
                worker.wait(rng.uniform(0.1, 1.5))
            except subprocess.TimeoutExpired:
                worker.kill()
                kills -= 1
        done = worker.wait() == 0
        now = {p.parent.name: p.stat().st_ino for p in folder.glob("items/[!.]*/item.json")}
        assert kept.items() <= now.items(), "a finished item is gone, or was done again"
        kept = now
        if done:
            assert files(folder) == files(threads)
            if kills == 0:
                break
            # As many kills as asked for, each in the middle of the work.
            shutil.rmtree(folder)
            kept = {}


def test_episodes(threads: Path) -> None:
    episodes = scandent.datasets.load(threads)
    assert len(episodes) == 2
    for episode, folder in zip(episodes, episodes.folders):
        certificate = scandent.verify(folder / "plan.json")
        assert certificate.passes and certificate.conditions == []
        plan = scandent.Plan.load(folder / "plan.json")
        assert episode.card["plan"] == plan.record and plan.motion is not None
        assert np.array_equal(episode.q, plan.motion.q)
        assert np.array_equal(episode.wrenches, plan.motion.wrenches, equal_nan=True)
        assert (folder / "motion.npz").read_bytes() == plan.export("npz")
        assert len(episode.terrain) == len(plan.record["faces"])


def test_parquet(threads: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="SKIPPED: no pyarrow (pip install pyarrow)")
    table = parquet.read_table(scandent.datasets.parquet(threads)).to_pylist()
    assert [row["ended"] for row in table] == ["solved", "error", "solved", "budget-spent"]
    assert table[0]["seed"] == 1 and table[0]["motion_s"] > 0.0 and table[1]["seed"] is None


def test_simulations_are_items(threads: Path, tmp_path: Path) -> None:
    pytest.importorskip("mujoco", reason="SKIPPED: no mujoco (pip install mujoco)")
    plan = threads / "items" / "a" / "plan.json"
    shown = scandent.simulate(plan, hold=False, perturb="friction", runs=2, seed=5)
    assert shown.record["execution"]["pass"] and len(shown.record["robust"]) == 2
    assert len(shown.trace["t_s"]) == len(shown.trace["front_left_n"]) > 100
    item = {"item": "a-5", "plan": str(plan), "execute": True, "perturb": "friction", "runs": 2, "seed": 5}
    (row,) = scandent.batch([item], tmp_path)
    assert row["ended"] == ("executed" if shown.passes else "not-executed")
    assert json.loads((tmp_path / "items" / "a-5" / "simulation.json").read_text()) == shown.record
