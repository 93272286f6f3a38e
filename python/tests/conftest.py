"""What the tests share: two small worlds, robots, and the program beside the package."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Callable

import numpy as np
import numpy.typing as npt
import pytest

import scandent

ROOT = Path(__file__).resolve().parents[2]


def rectangle(x0: float, x1: float, z: float) -> list[list[float]]:
    """A level rectangle 1.6 m wide."""
    return [[x0, -0.8, z], [x1, -0.8, z], [x1, 0.8, z], [x0, 0.8, z]]


@pytest.fixture(scope="session")
def hrp2() -> scandent.Robot:
    return scandent.Robot.load("builtin:hrp2")


@pytest.fixture(scope="session")
def step() -> scandent.Terrain:
    """A floor, and a step of 10 cm half a metre ahead."""
    return scandent.Terrain.from_polygons({"floor": rectangle(-0.5, 0.45, 0.0), "step": rectangle(0.45, 1.4, 0.1)})


@pytest.fixture(scope="session")
def climb(step: scandent.Terrain, hrp2: scandent.Robot) -> scandent.Plan:
    return scandent.plan(step, hrp2, "half_sitting", [0.7, 0.0])


@pytest.fixture(scope="session")
def program_file() -> str:
    """The command line; skipped where it is not built."""
    place = os.environ.get("SCANDENT_PROGRAM")
    if place is None:
        pytest.skip("SKIPPED: SCANDENT_PROGRAM names no program")
    return place


@pytest.fixture(scope="session")
def program(program_file: str) -> Callable[..., str]:
    def run(*arguments: object, cwd: Path) -> str:
        command = [program_file, *map(str, arguments)]
        done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture()
def flat() -> npt.NDArray[np.uint16]:
    """A wall 2 m ahead of a small camera, in mm."""
    return np.full((120, 160), 2000, dtype=np.uint16)
