"""A robot of one's own, from its URDF: what was read, what was proposed, and where it can stand.

    python own_robot.py ROBOT.urdf [ROBOT.srdf ROBOT.contacts.toml]
"""

from __future__ import annotations

import sys

import numpy as np

import scandent


def main(urdf: str, srdf: str | None = None, contacts: str | None = None) -> None:
    robot = scandent.Robot.load(urdf, srdf, contacts)
    print(robot, f"{robot.mass_kg:.1f} kg", *robot.notes, sep="\n  ")
    feet = [patch.name for patch in robot.patches.values() if "foot" in patch.roles]
    floor = scandent.Terrain.from_polygons({"floor": np.array([[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0.0]])})

    standing = scandent.solve_posture(robot, floor, dict.fromkeys(feet, "floor"))
    print("on all feet:", standing.outcome, standing.reason or standing.margins)
    for foot in feet:
        others = [name for name in feet if name != foot]
        if others:
            found = scandent.solve_posture(robot, floor, dict.fromkeys(others, "floor"))
            print(f"without {foot}:", found.outcome, found.reason or "")


if __name__ == "__main__":
    main(*(sys.argv[1:] or ["builtin:quadruped"]))
