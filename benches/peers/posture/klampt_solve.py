#!/usr/bin/env python3
"""The peers' problem in Klampt: numerical inverse kinematics with random restarts and an equilibrium test.

Every restart solves the contacts' poses within the joint limits; the first solution is taken that passes
Klampt's own tests: forces at the patch vertices in linearised friction cones balance it, the torques of
least norm are within their limits, and no watched pair of links collides. Fixed contacts only. The first
start is the one that Scandent has; the restarts draw joints within their limits and the base within BASE_M
and BASE_RAD of it.
"""

import random
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import klampt
import numpy as np
from klampt.model import contact as klampt_contact
from klampt.model import ik

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from problem_file import solve_file  # noqa: E402
from robot import GRAVITY, base_guess, touching_pose  # noqa: E402

RESTARTS = 200
ITERATIONS = 200
TOLERANCE = 1e-3
BASE_M = 0.3
BASE_RAD = 0.5


def with_plain_paths(urdf):
    """A file of the URDF with the paths of its collision meshes written out, less mimicry."""
    tree = ElementTree.parse(urdf)
    for link in tree.getroot().iter("link"):
        for shape in link.findall("visual"):
            link.remove(shape)
    for mesh in tree.getroot().iter("mesh"):
        inside = mesh.get("filename").removeprefix("package://")
        found = [f / inside for f in Path(urdf).parents if (f / inside).exists()]
        mesh.set("filename", str(found[0] if found else inside))
    for joint in tree.getroot().iter("joint"):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
    file = tempfile.NamedTemporaryFile(suffix=".urdf", delete=False)
    tree.write(file.name)
    return file.name


class Solver:
    """Klampt's robot: six links of a floating base (x, y, z, then yaw, pitch, roll), one link a URDF link."""

    def __init__(self, robot):
        self.robot = robot
        self.world = klampt.WorldModel()
        self.model = self.world.loadRobot(with_plain_paths(robot.urdf))
        child = {}
        for joint in ElementTree.parse(robot.urdf).getroot().findall("joint"):
            child[joint.get("name")] = joint.find("child").get("link")
        self.links = [self.model.link(child[n]).getIndex() for n in robot.joint_names]
        self.base = self.model.link(5)
        self.low, self.high = self.model.getJointLimits()
        self.watch_pairs(robot)
        # What Klampt prepares on the first question is no part of a problem's time.
        self.model.selfCollides()

    def watch_pairs(self, robot):
        """The pairs of links that the audit watches, and no others."""
        shapes = robot.geometry.geometryObjects
        link_of = [robot.model.frames[g.parentFrame].name for g in shapes]
        watched = set()
        for pair in robot.geometry.collisionPairs:
            watched.add(frozenset((link_of[pair.first], link_of[pair.second])))
        links = [self.model.link(i) for i in range(5, self.model.numLinks())]
        for i, a in enumerate(links):
            for b in links[:i]:
                on = frozenset((a.getName(), b.getName())) in watched
                # Only what changes: enabling a pair of links without shapes corrupts Klampt's heap.
                if self.model.selfCollisionEnabled(a.getIndex(), b.getIndex()) != on:
                    self.model.enableSelfCollision(a.getIndex(), b.getIndex(), on)

    def start(self, q):
        """Klampt's configuration of Pinocchio's, whose base is upright; sets the base's limits around it."""
        yaw = 2.0 * np.arctan2(q[5], q[6])
        x = [0.0] * self.model.numLinks()
        x[:4] = [*q[:3], yaw]
        for i, value in zip(self.links, q[7:]):
            x[i] = value
        low, high = list(self.low), list(self.high)
        for i in range(6):
            around = BASE_M if i < 3 else BASE_RAD
            low[i], high[i] = x[i] - around, x[i] + around
        self.model.setJointLimits(low, high)
        self.model.setConfig(x)

    def configuration(self):
        """[p_WB, quat_xyzw, joints] of Klampt's robot."""
        import pinocchio as pin

        R, t = self.base.getTransform()
        quaternion = pin.Quaternion(np.array(R).reshape(3, 3).T)
        x = self.model.getConfig()
        return [*t, *quaternion.coeffs(), *(x[i] for i in self.links)]

    def holds(self, holds):
        """Whether the torques of least norm that Klampt finds are within their limits."""
        found = klampt_contact.equilibrium_torques(self.model, holds, (0.0, 0.0, -GRAVITY), norm=1)
        if found is None:
            return False
        limits = self.model.getTorqueLimits()
        return all(abs(found[0][i]) <= limits[i] for i in self.links)

    def solve(self, problem, number):
        random.seed(number)
        klampt.robotsim.set_random_seed(number)
        self.start(base_guess(self.robot, problem))
        objectives, touching, holds = [], [], []
        for contact in problem["contacts"]:
            patch = self.robot.patch_of(contact)
            link = self.model.link(patch.link)
            X_WC = touching_pose(contact, patch)
            X_WL = X_WC * patch.X_LC.inverse()
            objectives.append(
                ik.objective(link, R=X_WL.rotation.T.flatten().tolist(), t=X_WL.translation.tolist())
            )
            normal = X_WC.rotation[:, 2].tolist()
            points = [
                klampt_contact.ContactPoint(X_WC.act(v).tolist(), normal, problem["mu"])
                for v in patch.vertices
            ]
            touching.extend(points)
            hold = klampt_contact.Hold()
            hold.link = link.getIndex()
            hold.contacts = points
            hold.ikConstraint = objectives[-1]
            holds.append(hold)
        weight = [0.0, 0.0, -self.robot.mass * GRAVITY]

        def feasible():
            forces = klampt_contact.com_equilibrium(touching, weight, self.model.getCom())
            return forces is not None and self.holds(holds) and not self.model.selfCollides()

        found = ik.solve_global(
            objectives,
            iters=ITERATIONS,
            tol=TOLERANCE,
            activeDofs=[*range(6), *self.links],
            numRestarts=RESTARTS,
            feasibilityCheck=feasible,
        )
        return self.configuration() if found else None


if __name__ == "__main__":
    solve_file("klampt", __doc__, Solver)
