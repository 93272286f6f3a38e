"""From a depth image to a verified plan, its files and a page to look at.

    python scan_to_plan.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt

import scandent


def render(K: npt.NDArray[np.float64], T_WV: npt.NDArray[np.float64]) -> npt.NDArray[np.uint16]:
    """What a depth camera there sees of a floor and two steps, in mm: stands in for your camera."""
    rays_V = np.stack(np.meshgrid(np.arange(640.0), np.arange(480.0)), axis=-1)
    rays_V = np.concatenate([(rays_V - K[:2, 2]) / [K[0, 0], K[1, 1]], np.ones((480, 640, 1))], axis=-1)
    rays_W, eye = rays_V @ T_WV[:3, :3].T, T_WV[:3, 3]
    nearest = np.full((480, 640), np.inf)
    boxes = [(-1.0, 4.0, -0.2, 0.0), (0.6, 1.1, 0.0, 0.1), (1.1, 2.5, 0.0, 0.2)]
    for x0, x1, z0, z1 in boxes:
        low, high = np.array([x0, -1.2, z0]), np.array([x1, 1.2, z1])
        with np.errstate(divide="ignore"):
            ends = np.stack([(low - eye) / rays_W, (high - eye) / rays_W])
        enters, leaves = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
        nearest = np.where((enters < leaves) & (enters > 0.0), np.minimum(nearest, enters), nearest)
    seen = np.where(nearest < 5.0, nearest, 0.0)
    return np.round(1000.0 * seen).astype(np.uint16)


def main(folder: Path) -> None:
    K = np.array([[525.0, 0.0, 319.5], [0.0, 525.0, 239.5], [0.0, 0.0, 1.0]])
    # The optical frame (x right, y down, z ahead) 1.5 m over the ground, looking 45° down along x.
    c = np.sqrt(0.5)
    T_WV = np.array([[0, -c, c, 0.0], [-1, 0, 0, 0.0], [0, -c, -c, 1.5], [0, 0, 0, 1.0]])
    terrain = scandent.perceive(render(K, T_WV), K, T_WV, sensor="xtion")
    print(terrain, *terrain.notes, sep="\n  ")

    robot = scandent.Robot.load("builtin:hrp2")
    try:
        plan = scandent.plan(terrain, robot, "half_sitting", goal=[0.9, 0.0])
    except scandent.Unsolved as error:
        sys.exit(f"{error}\ntry: {'; '.join(error.to_try)}")
    assert plan.motion is not None and plan.certificate is not None
    print(plan, "verified:", plan.certificate.passes)
    print("motion.q", plan.motion.q.shape, "tau", plan.motion.tau.shape, "wrenches", plan.motion.wrenches.shape)
    for stance in plan.stances:
        loads = {patch: round(float(f.sum(axis=0)[2])) for patch, f in stance.forces.items()}
        print(stance.index, stance.change["kind"], "vertical forces, N:", loads)
    plan.save(folder)
    print("look at", folder / "view.html")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/scan_to_plan"))
