"""Configurations and motions as Pinocchio has them.

Pinocchio orders joints by name, has the rates of a free flyer in the base's axes, and two coordinates (cosine
and sine) for a joint without limits. The functions below go by the names of joints, and need nothing but the
model: ``pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())``.
"""

from __future__ import annotations

from typing import Any, List, NamedTuple, Sequence, Tuple

import numpy as np

from ._arguments import Array, numbers
from ._errors import InputError
from ._plan import Motion


class Trajectory(NamedTuple):
    """A motion in Pinocchio's order, a row a sample."""

    #: Configurations (n, model.nq).
    q: Array
    #: Velocities (n, model.nv), the base's in its own axes.
    v: Array
    #: Accelerations (n, model.nv), the base's the derivative of those.
    a: Array
    #: Torques (n, model.nv), zero on the base.
    tau: Array


def configuration(model: Any, joint_names: Sequence[str], q: Any) -> Array:
    """A posture, or rows of them, in Pinocchio's order: (7 + joints) becomes (model.nq)."""
    rows = np.asarray(q, dtype=np.float64)
    flat = numbers(np.atleast_2d(rows), "q", None, 7 + len(joint_names))
    found = np.zeros((len(flat), model.nq))
    for joint in model.joints:
        # What the plan does not move stays at zero, a joint without limits at the angle zero.
        if joint.nv == 1 and joint.nq == 2:
            found[:, joint.idx_q] = 1.0
    found[:, :7] = flat[:, :7]
    for column, (joint, _) in enumerate(_joints(model, joint_names)):
        angle = flat[:, 7 + column]
        if joint.nq == 1:
            found[:, joint.idx_q] = angle
        else:
            found[:, joint.idx_q], found[:, joint.idx_q + 1] = np.cos(angle), np.sin(angle)
    return found if rows.ndim == 2 else found[0]


def trajectory(model: Any, joint_names: Sequence[str], motion: Motion) -> Trajectory:
    """A motion in Pinocchio's order: ``pin.rnea(model, data, q, v, a)`` less the contacts' forces is ``tau``."""
    q = configuration(model, joint_names, motion.q)
    v, a, tau = (np.zeros((len(q), model.nv)) for _ in range(3))
    R_WB = _rotations(motion.q[:, 3:7])
    for columns in (slice(0, 3), slice(3, 6)):
        for ours, theirs in ((motion.v, v), (motion.a, a)):
            theirs[:, columns] = np.einsum("nji,nj->ni", R_WB, ours[:, columns])
    # The axes turn with the base.
    a[:, :3] -= np.cross(v[:, 3:6], v[:, :3])
    for column, (joint, _) in enumerate(_joints(model, joint_names)):
        v[:, joint.idx_v] = motion.v[:, 6 + column]
        a[:, joint.idx_v] = motion.a[:, 6 + column]
        tau[:, joint.idx_v] = motion.tau[:, column]
    return Trajectory(q, v, a, tau)


def _joints(model: Any, joint_names: Sequence[str]) -> List[Tuple[Any, str]]:
    found = []
    for name in joint_names:
        if not model.existJointName(name):
            raise InputError(f"model has no joint {name!r}: is it the plan's robot?", "model")
        found.append((model.joints[model.getJointId(name)], name))
    return found


def _rotations(quaternions: Array) -> Array:
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
