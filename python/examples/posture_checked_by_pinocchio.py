"""A posture whose forces and torques Pinocchio finds in equilibrium (pip install pin).

    python posture_checked_by_pinocchio.py ROBOT.urdf [ROBOT.srdf ROBOT.contacts.toml]
"""

from __future__ import annotations

import sys

import numpy as np
import pinocchio as pin

import scandent


def main(urdf: str, *beside: str) -> None:
    robot = scandent.Robot.load(urdf, *beside)
    feet = [patch for patch in robot.patches.values() if "foot" in patch.roles]
    floor = scandent.Terrain.from_polygons({"floor": np.array([[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0.0]])})
    found = scandent.solve_posture(robot, floor, {foot.name: "floor" for foot in feet})
    if found.q is None:
        sys.exit(f"{found.outcome}: {found.reason}")

    model = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())
    data = model.createData()
    q = scandent.pinocchio.configuration(model, robot.joint_names, found.q)
    # What gravity asks of every coordinate, less what the contacts' forces do.
    left = pin.computeGeneralizedGravity(model, data, q)
    pin.forwardKinematics(model, data, q)
    pin.updateFramePlacements(model, data)
    for foot in feet:
        frame = model.getFrameId(foot.link)
        J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
        for point, force in zip(found.force_points_W[foot.name], found.forces[foot.name]):
            arm = point - data.oMf[frame].translation
            left -= J.T @ np.concatenate([force, np.cross(arm, force)])
    limits = model.effortLimit[6:]
    use = np.abs(left[6:])[limits > 0] / limits[limits > 0]
    print(f"on the base, over the weight: {np.abs(left[:6]).max() / (9.81 * robot.mass_kg):.1e}")
    print(f"torques: {use.max(initial=0.0):.2f} of the limits; scandent says {found.margins['torque_use']:.2f}")
    assert np.abs(left[:6]).max() < 1e-3 * 9.81 * robot.mass_kg


if __name__ == "__main__":
    main(*sys.argv[1:])
