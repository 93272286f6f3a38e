"""Replays motion.json by Pinocchio: what its own dynamics say of the stated forces and torques.

    python replay.py FOLDER ROBOT.urdf      # FOLDER holds plan.json and motion.json

Prints the largest differences over all samples: of force and moment on the floating base over the
weight (m), of torques over the largest one, of zero-moment points (m). Exits 1 where one is above 1 %
(1 cm of a zero-moment point).
"""

import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin


def main(folder, urdf):
    plan = json.loads((folder / "plan.json").read_text())
    motion = json.loads((folder / "motion.json").read_text())
    model = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())
    data = model.createData()
    ids = [model.getJointId(name) for name in plan["robot"]["joint_names"]]
    at_q = [model.joints[i].idx_q for i in ids]
    at_v = [model.joints[i].idx_v for i in ids]
    locked = [j for j in model.joints[1:] if j.idx_q not in at_q and j.nq and j.idx_q > 0]
    assert not locked, "the plan has not all joints of the URDF"
    weight = 9.81 * sum(inertia.mass for inertia in model.inertias)
    worst = dict.fromkeys(["force", "moment", "torque", "zmp"], 0.0)
    largest = max(abs(t) for s in motion["samples"] for t in s["tau"])
    for sample, phase in samples(motion):
        q, v, a = state(model, sample, at_q, at_v)
        needed = pin.rnea(model, data, q, v, a)
        pin.forwardKinematics(model, data, q)
        pin.updateFramePlacements(model, data)
        R = data.oMi[1].rotation
        force, moment, origin = np.zeros(3), np.zeros(3), data.oMi[1].translation
        for contact, forces in zip(phase["contacts"], sample["forces_W"]):
            frame = model.getFrameId(contact["link"])
            J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
            for p, f in zip(contact["force_points_W"], np.array(forces)):
                arm = np.array(p) - data.oMf[frame].translation
                needed -= J.T @ np.concatenate([f, np.cross(arm, f)])
                force += f
                moment += np.cross(np.array(p) - origin, f)
        left = np.concatenate([R @ needed[:3], R @ needed[3:6]])
        keep(worst, "force", np.linalg.norm(left[:3]) / weight)
        keep(worst, "moment", np.linalg.norm(left[3:]) / weight)
        keep(worst, "torque", np.abs(needed[at_v] - sample["tau"]).max() / largest)
        keep(worst, "zmp", np.linalg.norm(zmp(force, moment) - zmp(force + left[:3], moment + left[3:])))
    print(", ".join(f"{name} {value:.2e}" for name, value in worst.items()))
    return int(max(worst.values()) > 0.01)


def samples(motion):
    """Every sample with its phase: the later one at a border."""
    phases = iter(motion["phases"])
    phase, later = next(phases), next(phases, None)
    for sample in motion["samples"]:
        while later and sample["t_s"] >= later["t_start_s"] - 1e-6:
            phase, later = later, next(phases, None)
        yield sample, phase


def state(model, sample, at_q, at_v):
    """q, v, a in Pinocchio's order; its base rates are in the base's axes, ours in W."""
    q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    q[:7], q[at_q] = sample["q"][:7], sample["q"][7:]
    R = pin.Quaternion(q[3:7]).normalized().toRotationMatrix()
    rates, changes = np.array(sample["v"]), np.array(sample["a"])
    v[:3], v[3:6], v[at_v] = R.T @ rates[:3], R.T @ rates[3:6], rates[6:]
    a[:3] = R.T @ changes[:3] - np.cross(v[3:6], v[:3])
    a[3:6], a[at_v] = R.T @ changes[3:6], changes[6:]
    return q, v, a


def zmp(force, moment):
    """Where on the base's level the force acts without a moment but about the vertical."""
    return np.array([-moment[1], moment[0]]) / force[2]


def keep(worst, name, value):
    worst[name] = max(worst[name], float(value))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2]))
