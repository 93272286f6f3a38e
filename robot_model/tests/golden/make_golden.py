"""Golden kinematics by Pinocchio: link poses, centre of mass, gravity torques, Jacobians.

    python3 -m venv /tmp/golden && /tmp/golden/bin/pip install pin==4.1.0 example-robot-data==6.0.0
    /tmp/golden/bin/python robot_model/tests/golden/make_golden.py

Writes test_tree.json and talos_reduced.json beside itself. Everything is put into the crate's
conventions: v = [v_B, omega_B, joints], both of the base in W (Pinocchio has them in B).
"""

import json
import pathlib

import numpy as np
import pinocchio as pin

HERE = pathlib.Path(__file__).resolve().parent
ROBOTS = (
    pathlib.Path(pin.__file__).resolve().parents[4] / "share/example-robot-data/robots"
)
CASES = [
    # name, URDF, links whose Jacobians are wanted, joints locked at a value (mimics), seed
    ("test_tree", HERE / "test_tree.urdf", ["sole", "wheel", "tooth"], {"bite": 0.25}, 1),
    (
        "talos_reduced",
        ROBOTS / "talos_data/robots/talos_reduced.urdf",
        ["left_sole_link", "gripper_right_base_link", "head_2_link"],
        {},
        2,
    ),
]
CONFIGURATIONS = 3


def write(name, urdf, links, locked, seed):
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    data = model.createData()
    rng = np.random.default_rng(seed)
    joints = [i for i in range(2, model.njoints) if model.names[i] not in locked]
    samples = []
    for _ in range(CONFIGURATIONS):
        q = pin.neutral(model)
        q[:3] = rng.uniform(-1, 1, 3)
        quaternion = rng.normal(size=4)
        q[3:7] = quaternion / np.linalg.norm(quaternion)
        values = {}
        for i in range(2, model.njoints):
            joint = model.joints[i]
            if model.names[i] in locked:
                value = locked[model.names[i]]
            elif joint.nq == 2:
                value = rng.uniform(-3, 3)
            else:
                low = model.lowerPositionLimit[joint.idx_q]
                value = rng.uniform(low, model.upperPositionLimit[joint.idx_q])
            # Pinocchio keeps a continuous joint as a point on the circle.
            angle = [np.cos(value), np.sin(value)] if joint.nq == 2 else [value]
            q[joint.idx_q : joint.idx_q + joint.nq] = angle
            if model.names[i] not in locked:
                values[model.names[i]] = value
        samples.append(sample(model, data, q, values, links, joints))
    golden = {
        "made_by": f"make_golden.py, pinocchio {pin.__version__}",
        "mass_kg": pin.computeTotalMass(model),
        "configurations": samples,
    }
    path = HERE / f"{name}.json"
    path.write_text(json.dumps(golden, indent=None, separators=(",", ":")) + "\n")
    print(path, path.stat().st_size, "bytes")


def sample(model, data, q, values, links, joints):
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    X_WB = data.oMi[1]
    columns = [model.joints[i].idx_v for i in joints]
    names = [model.names[i] for i in joints]

    def in_world(jacobian):
        """Base columns for v_B and omega_B in W; the others by joint."""
        base = np.hstack([jacobian[:, 0:3] @ X_WB.rotation.T, jacobian[:, 3:6] @ X_WB.rotation.T])
        return {
            "base": base.tolist(),
            "joints": {n: jacobian[:, c].tolist() for n, c in zip(names, columns)},
        }

    poses = {}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and frame.name != "universe":
            X_WL = data.oMf[model.getFrameId(frame.name, pin.FrameType.BODY)]
            poses[frame.name] = {
                "p": X_WL.translation.tolist(),
                "quat_xyzw": pin.Quaternion(X_WL.rotation).coeffs().tolist(),
            }
    jacobians = {}
    for link in links:
        frame = model.getFrameId(link, pin.FrameType.BODY)
        jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        jacobians[link] = in_world(jacobian)
    com_jacobian = in_world(pin.jacobianCenterOfMass(model, data, q))
    gravity = pin.computeGeneralizedGravity(model, data, q)
    return {
        "p_WB": q[:3].tolist(),
        "quat_xyzw": q[3:7].tolist(),
        "joints": values,
        "poses": poses,
        "com": pin.centerOfMass(model, data, q).tolist(),
        "com_jacobian": com_jacobian,
        "gravity": {
            "force_W": (X_WB.rotation @ gravity[0:3]).tolist(),
            "moment_W": (X_WB.rotation @ gravity[3:6]).tolist(),
            "joints": {n: gravity[c] for n, c in zip(names, columns)},
        },
        "jacobians": jacobians,
    }


if __name__ == "__main__":
    for case in CASES:
        write(*case)
