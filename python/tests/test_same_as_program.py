"""The package gives the bytes that the command line writes."""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Callable

import numpy as np
import numpy.typing as npt
import pytest

import scandent

Program = Callable[..., str]
#: As the package says them: a plan holds the words that it was asked for in.
FLAGS = ["--robot", "builtin:hrp2", "--start=half_sitting", "--goal=0.7,0.0"]


def png(image: npt.NDArray[np.uint16]) -> bytes:
    """A 16-bit grey PNG."""
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in image)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", image.shape[1], image.shape[0], 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def test_surfaces_of_an_image(program: Program, tmp_path: Path, flat: npt.NDArray[np.uint16]) -> None:
    flat[40:80, 60:110] = 1500
    (tmp_path / "depth.png").write_bytes(png(flat))
    how = ["--sensor=150,150,79.5,59.5", "--pose=0,0,1,-0.5,0.5,-0.5,0.5"]
    program("surfaces", "depth.png", *how, "-o", "surfaces.json", cwd=tmp_path)
    terrain = scandent.perceive(flat, [150.0, 150.0, 79.5, 59.5], [0.0, 0.0, 1.0, -0.5, 0.5, -0.5, 0.5])
    assert terrain.to_json() == (tmp_path / "surfaces.json").read_text()


def test_plans(
    program: Program, tmp_path: Path, step: scandent.Terrain, climb: scandent.Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    step.save(tmp_path / "surfaces.json")
    program("plan", "--surfaces", "surfaces.json", *FLAGS, "-o", "out", cwd=tmp_path)
    climb.save(tmp_path / "mine")
    names = sorted(p.name for p in (tmp_path / "out").iterdir())
    assert names == sorted(p.name for p in (tmp_path / "mine").iterdir())
    for name in names:
        if name != "report.json":
            assert (tmp_path / "mine" / name).read_bytes() == (tmp_path / "out" / name).read_bytes(), name

    # The program finds the package's world again, and the package the program's.
    program("verify", "mine/plan.json", "-o", "certificate.json", cwd=tmp_path)
    monkeypatch.chdir(tmp_path)
    certificate = scandent.verify("out/plan.json")
    assert certificate.passes and certificate.conditions == []
    assert certificate.record == json.loads((tmp_path / "certificate.json").read_text())

    # What is read back is what was made.
    read = scandent.Plan.load("mine/plan.json")
    assert read.record == climb.record
    assert np.array_equal(read.motion.q, climb.motion.q)  # type: ignore[union-attr]
    assert read.export("npz") == climb.export("npz")
    # Results that were read may be replaced.
    climb.save("mine")


def test_a_file_of_surfaces_and_settings(
    program: Program, tmp_path: Path, step: scandent.Terrain, hrp2: scandent.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    step.save("world.json")
    rest = ["--set", "planner.nodes_max=500", "--seed=3"]
    program("plan", "--surfaces", "world.json", "--goal", "0.7,0", *FLAGS[:3], *rest, "-o", "out", cwd=tmp_path)
    terrain = scandent.Terrain.load("world.json")
    made = scandent.plan(terrain, hrp2, "half_sitting", [0.7, 0.0], config={"planner": {"nodes_max": 500}}, seed=3)
    made.save("mine")
    wrote, mine = (json.loads(Path(folder, "plan.json").read_text()) for folder in ("out", "mine"))
    # The flags may be written in other words; all else is the same.
    for plan in (wrote, mine):
        plan["inputs"] = [i for i in plan["inputs"] if i["role"] != "flags"]
    assert mine == wrote
    assert Path("mine/motion.json").read_bytes() == Path("out/motion.json").read_bytes()


def test_postures(program: Program, tmp_path: Path, hrp2: scandent.Robot) -> None:
    flags = ["--robot", "builtin:hrp2"]
    program("posture-sets", *flags, "--family", "hard", "--count", 5, "--seed", 2, "-o", "set.json", cwd=tmp_path)
    assert scandent.draw_postures(hrp2, "hard", 5, seed=2) == (tmp_path / "set.json").read_bytes()
    program("posture", "set.json", *flags, "-o", "solved.json", cwd=tmp_path)
    wrote = json.loads((tmp_path / "solved.json").read_text())["results"]
    found = scandent.solve_postures(hrp2, tmp_path / "set.json")
    assert found.outcomes == [answer["outcome"] for answer in wrote]
    for i, answer in enumerate(wrote):
        if answer["q"] is not None:
            assert found.q[i].tolist() == answer["q"]


def test_a_scene_that_ships(program: Program, tmp_path: Path) -> None:
    program("run", "irregular-stairs", "-o", "out", cwd=tmp_path)
    made = scandent.run("irregular-stairs", threads=1)
    made.save(tmp_path / "mine")
    for name in ("plan.json", "motion.json", "certificate.json", "view.html"):
        assert (tmp_path / "mine" / name).read_bytes() == (tmp_path / "out/irregular-stairs" / name).read_bytes(), name
