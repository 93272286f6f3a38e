#!/usr/bin/env python3
"""The peers' problem in Drake: inverse kinematics with contact forces, solved by SNOPT.

  min  |joints - rest|^2 + small forces
  s.t. patch at its pose (0.1 mm, 1e-4 rad), joint limits, unit quaternion
       forces in a pyramid of 8 sides inscribed in the friction cone
       0 = gravity + sum J'f on the base,  |g(q) - J'f| <= tau_max on the joints

Gradients come from Drake's automatic differentiation. Fixed contacts only; collisions are left out, as
Drake reads no collision meshes in the STL format. The first start is the one that Scandent has, the
resting posture over the contacts; STARTS - 1 more have drawn joints near it.
"""

import math
import sys
from pathlib import Path

import numpy as np
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, InitializeAutoDiff
from pydrake.math import RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.solvers import SnoptSolver, SolverOptions

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from problem_file import solve_file  # noqa: E402
from robot import GRAVITY, base_guess, touching_pose  # noqa: E402

POSITION_M = 1e-4
ANGLE_RAD = 1e-4
SIDES = 8
STARTS = 3


def without_geometry(urdf):
    """The URDF's text less its shapes and what Drake refuses: mimicry and friction of joints."""
    import xml.etree.ElementTree as ElementTree

    tree = ElementTree.parse(urdf)
    for link in tree.getroot().iter("link"):
        for tag in ("visual", "collision"):
            for shape in link.findall(tag):
                link.remove(shape)
    for joint in tree.getroot().iter("joint"):
        for tag in ("mimic", "dynamics"):
            for of in joint.findall(tag):
                joint.remove(of)
    for transmission in tree.getroot().findall("transmission"):
        tree.getroot().remove(transmission)
    return ElementTree.tostring(tree.getroot(), encoding="unicode")


def rotation_matrix(R):
    """Drake's rotation of a matrix that is one up to the rounding of written decimals."""
    u, _, v = np.linalg.svd(R)
    return RotationMatrix(u @ v)


class Solver:
    def __init__(self, robot):
        self.robot = robot
        self.plant = MultibodyPlant(0.0)
        Parser(self.plant).AddModelsFromString(without_geometry(robot.urdf), "urdf")
        self.plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -GRAVITY])
        self.plant.Finalize()
        self.joints = [self.plant.GetJointByName(n) for n in robot.joint_names]
        self.nq, self.nv = self.plant.num_positions(), self.plant.num_velocities()
        self.ad = self.plant.ToAutoDiffXd()
        self.context_ad = self.ad.CreateDefaultContext()
        self.context_d = self.plant.CreateDefaultContext()
        body = self.plant.get_body(self.plant.GetFloatingBaseBodies().pop())
        self.q0, self.v0 = body.floating_positions_start(), body.floating_velocities_start_in_v()
        self.effort = np.full(self.nv, np.inf)
        for joint, effort in zip(self.joints, robot.effort):
            self.effort[joint.velocity_start()] = effort

    def to_drake(self, q):
        """Pinocchio's [p, xyzw, joints] as Drake's positions."""
        out = np.zeros(self.nq)
        b = self.q0
        out[b : b + 4] = [q[6], q[3], q[4], q[5]]
        out[b + 4 : b + 7] = q[:3]
        for i, joint in enumerate(self.joints):
            out[joint.position_start()] = q[7 + i]
        return out

    def from_drake(self, x):
        b = self.q0
        quaternion = x[b : b + 4] / np.linalg.norm(x[b : b + 4])
        joints = [x[j.position_start()] for j in self.joints]
        return [*x[b + 4 : b + 7], *quaternion[1:], quaternion[0], *joints]

    def residual(self, plant, context, q, forces, points):
        """Generalized forces that the joints must exert: -gravity - sum J'f, over the weight."""
        plant.SetPositions(context, q)
        tau = -plant.CalcGravityGeneralizedForces(context)
        world = plant.world_frame()
        for (link, p_LV), f in zip(points, forces):
            frame = plant.GetFrameByName(link)
            J = plant.CalcJacobianTranslationalVelocity(
                context, JacobianWrtVariable.kV, frame, p_LV, world, world
            )
            tau = tau - J.T @ f
        return tau

    def balance(self, points):
        """The constraint's function of [q, forces over the weight]."""
        n, weight = self.nq, self.robot.weight

        def evaluate(x):
            if x.dtype == float:
                forces = x[n:].reshape(-1, 3) * weight
                return self.residual(self.plant, self.context_d, x[:n], forces, points) / weight
            value = np.array([v.value() for v in x])
            gradient = ExtractGradient(x)
            q = InitializeAutoDiff(value[:n])[:, 0]
            forces = value[n:].reshape(-1, 3) * weight
            tau = self.residual(self.ad, self.context_ad, q, forces, points) / weight
            by_q = ExtractGradient(tau.reshape(-1, 1))
            self.plant.SetPositions(self.context_d, value[:n])
            world = self.plant.world_frame()
            by_f = [
                -self.plant.CalcJacobianTranslationalVelocity(
                    self.context_d,
                    JacobianWrtVariable.kV,
                    self.plant.GetFrameByName(link),
                    p,
                    world,
                    world,
                ).T
                for link, p in points
            ]
            J = np.hstack([by_q, *by_f]) @ gradient
            return np.array([AutoDiffXd(t.value(), row) for t, row in zip(tau, J)])

        return evaluate

    def program(self, problem, reference):
        ik = InverseKinematics(self.plant, with_joint_limits=True)
        prog, q = ik.prog(), ik.q()
        world = self.plant.world_frame()
        points, axes = [], []
        for contact in problem["contacts"]:
            patch = self.robot.patch_of(contact)
            frame = self.plant.GetFrameByName(patch.link)
            X_WC = touching_pose(contact, patch)
            p, R = X_WC.translation, X_WC.rotation
            ik.AddPositionConstraint(frame, patch.X_LC.translation, world, p - POSITION_M, p + POSITION_M)
            R_LC = rotation_matrix(patch.X_LC.rotation)
            R_WC = rotation_matrix(R)
            ik.AddOrientationConstraint(frame, R_LC, world, R_WC, ANGLE_RAD)
            for v in patch.vertices:
                points.append((patch.link, patch.X_LC.act(v)))
                axes.append(R)
        f = prog.NewContinuousVariables(3 * len(points), "f")
        turns = 2.0 * math.pi * np.arange(SIDES) / SIDES
        inner = problem["mu"] * math.cos(math.pi / SIDES)
        # cos·fx + sin·fy <= mu cos(pi/SIDES) fz: a pyramid inside the cone.
        cone = np.column_stack([np.cos(turns), np.sin(turns), np.full(SIDES, -inner)])
        for i, R in enumerate(axes):
            of = f[3 * i : 3 * i + 3]
            prog.AddLinearConstraint(cone @ R.T, np.full(SIDES, -np.inf), np.zeros(SIDES), of)
        upper = self.effort / self.robot.weight
        upper[self.v0 : self.v0 + 6] = 0.0
        prog.AddConstraint(self.balance(points), -upper, upper, np.concatenate([q, f]))
        at = [j.position_start() for j in self.joints]
        prog.AddQuadraticErrorCost(0.1 * np.eye(len(at)), reference[at], q[at])
        prog.AddQuadraticCost(1e-2 * np.eye(len(f)), np.zeros(len(f)), f)
        return prog, q, f

    def solve(self, problem, number):
        guess = self.to_drake(base_guess(self.robot, problem))
        prog, q, f = self.program(problem, guess)
        options = SolverOptions()
        options.SetOption(SnoptSolver.id(), "Major iterations limit", 300)
        options.SetOption(SnoptSolver.id(), "Time limit", 20.0)
        random = np.random.default_rng(number)
        share = np.tile([0.0, 0.0, 1.0 / (len(f) / 3)], len(f) // 3)
        for start in range(STARTS):
            x = guess.copy()
            if start:
                for joint in self.joints:
                    low, high = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
                    i = joint.position_start()
                    x[i] = np.clip(x[i] + random.uniform(-0.3, 0.3) * (high - low), low, high)
            values = np.zeros(prog.num_vars())
            values[prog.FindDecisionVariableIndices(q)] = x
            values[prog.FindDecisionVariableIndices(f)] = share
            result = SnoptSolver().Solve(prog, values, options)
            if result.is_success():
                return self.from_drake(result.GetSolution(q))
        return None


if __name__ == "__main__":
    solve_file("drake", __doc__, Solver)
