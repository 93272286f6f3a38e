"""The margins of a plan, stance by stance; plotted where matplotlib is there.

    python margins.py [PLAN.json] [MARGINS.png]
"""

from __future__ import annotations

import sys

import numpy as np

import scandent

NAMES = ["friction_use", "torque_use", "joint_rad", "clearance_m"]


def walk() -> scandent.Plan:
    """Three steps of a quadruped on a plank."""
    plank = scandent.Terrain.from_polygons({"plank": np.array([[-1, -0.6, 0], [2, -0.6, 0], [2, 0.6, 0], [-1, 0.6, 0.0]])})
    return scandent.plan(plank, scandent.Robot.load("builtin:quadruped"), goal=[0.3, 0.0])


def main(file: str | None = None, picture: str | None = None) -> None:
    plan = walk() if file is None else scandent.Plan.load(file)
    rows = np.array([[s.margins[name] or np.nan for name in NAMES] for s in plan.stances])
    print("stance", *NAMES)
    for stance, row in zip(plan.stances, rows):
        print(f"{stance.index:6d}", *(f"{value:.3f}" for value in row))
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        return
    figure, axes = plt.subplots(len(NAMES), sharex=True, figsize=(7, 8))
    for axis, name, values in zip(axes, NAMES, rows.T):
        axis.step(range(len(values)), values, where="mid")
        axis.set_ylabel(name)
    axes[-1].set_xlabel("stance")
    figure.savefig(picture or "margins.png")


if __name__ == "__main__":
    main(*sys.argv[1:])
