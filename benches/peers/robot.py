"""A robot for the audit and for the peers: Pinocchio's model of a URDF, its shapes, its contact patches.

Everything is read anew from the files, by libraries that Scandent does not use.
Frames and units as in the file of problems: W with z up, m, rad, N.
"""

import json
import math
import tomllib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

GRAVITY = 9.81
FORMAT = "scandent-posture-problems/1"


@dataclass
class Patch:
    """A contact patch: C's pose in its link, vertices in C; a ball's radius or 0."""

    name: str
    link: str
    X_LC: pin.SE3
    vertices: np.ndarray
    radius: float
    roles: list


class Robot:
    """Model, collision geometry and patches."""

    def __init__(self, urdf, srdf, contacts):
        urdf = Path(urdf).resolve()
        self.urdf, self.srdf = urdf, srdf
        # package://NAME/… is looked for beside every folder above the URDF.
        folders = [str(f) for f in urdf.parents]
        self.model, self.geometry, _ = pin.buildModelsFromUrdf(
            str(urdf), folders, pin.JointModelFreeFlyer()
        )
        self.data = self.model.createData()
        self.mass = pin.computeTotalMass(self.model)
        self.weight = self.mass * GRAVITY
        self.joint_names = list(self.model.names)[2:]
        self.effort = np.array(self.model.effortLimit[6:], dtype=float)
        self.patches = {p.name: p for p in read_patches(contacts)}
        self.postures = read_postures(srdf) if srdf else {}
        self.watch_pairs(srdf)

    def watch_pairs(self, srdf):
        """Pairs of shapes of links that are no neighbours, less those of the SRDF and those that touch at rest."""
        geometry = self.geometry
        geometry.addAllCollisionPairs()
        if srdf:
            pin.removeCollisionPairs(self.model, geometry, str(srdf))
        shapes = geometry.geometryObjects
        parents = self.model.parents
        for pair in list(geometry.collisionPairs):
            a, b = (shapes[i].parentJoint for i in (pair.first, pair.second))
            if parents[a] == b or parents[b] == a:
                geometry.removeCollisionPair(pair)
        self.at_rest = self.colliding(self.resting())
        for a, b in self.at_rest:
            geometry.removeCollisionPair(pin.CollisionPair(geometry.getGeometryId(a), geometry.getGeometryId(b)))

    def resting(self):
        """q of half_sitting, standing or the first posture, the base at the origin."""
        q = pin.neutral(self.model)
        for name in ["half_sitting", "standing", *self.postures]:
            if name in self.postures:
                for joint, value in self.postures[name].items():
                    if self.model.existJointName(joint) and joint in self.joint_names:
                        q[self.model.joints[self.model.getJointId(joint)].idx_q] = value
                break
        return q

    def configuration(self, q, joint_names):
        """q = [p_WB, quat_xyzw, joints in the order of joint_names] in the order of the model."""
        full = self.resting()
        full[:7] = q[:7]
        full[3:7] /= np.linalg.norm(full[3:7])
        for name, value in zip(joint_names, q[7:]):
            full[self.model.joints[self.model.getJointId(name)].idx_q] = value
        return full

    def place(self, q):
        """Forward kinematics."""
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)

    def X_WC(self, patch):
        """Pose of a patch's frame, after place()."""
        return self.data.oMf[self.model.getFrameId(patch.link)] * patch.X_LC

    def joint_of(self, patch):
        """Index of the joint that carries a patch."""
        return self.model.frames[self.model.getFrameId(patch.link)].parentJoint

    def colliding(self, q):
        """Names of the watched pairs of shapes that overlap at q."""
        data = self.geometry.createData()
        pin.computeCollisions(self.model, self.data, self.geometry, data, q, False)
        names = [g.name for g in self.geometry.geometryObjects]
        return [
            (names[p.first], names[p.second])
            for p, r in zip(self.geometry.collisionPairs, data.collisionResults)
            if r.isCollision()
        ]

    def patch_of(self, contact):
        """The patch that a contact of a problem names: by name, by role, or the only one of its link."""
        on_link = [p for p in self.patches.values() if p.link == contact["link"]]
        wanted = contact.get("patch")
        if wanted is None:
            named = on_link
        else:
            named = [p for p in on_link if p.name == wanted] or [p for p in on_link if wanted in p.roles]
        if len(named) != 1:
            raise ValueError(f"{contact}: {len(named)} such patches")
        return named[0]


def read_patches(path):
    for patch in tomllib.loads(Path(path).read_text())["patch"]:
        R = pin.rpy.rpyToMatrix(*patch.get("rpy_rad", [0.0, 0.0, 0.0]))
        X_LC = pin.SE3(R, np.array(patch.get("position_m", [0.0, 0.0, 0.0])))
        flat = np.array(patch.get("polygon_m", [[0.0, 0.0]]), dtype=float)
        vertices = np.hstack([flat, np.zeros((len(flat), 1))])
        yield Patch(patch["name"], patch["link"], X_LC, vertices, patch.get("radius_m", 0.0), patch.get("roles", []))


def read_postures(path):
    postures = {}
    for state in ElementTree.parse(path).getroot().iter("group_state"):
        values = {}
        for joint in state.iter("joint"):
            numbers = joint.get("value", "").split()
            if len(numbers) == 1:
                values[joint.get("name")] = float(numbers[0])
        postures[state.get("name")] = values
    return postures


def read_problems(path):
    """The set of a file; a plain list is a set without surfaces."""
    read = json.loads(Path(path).read_text())
    if isinstance(read, list):
        read = {"format": FORMAT, "problems": read}
    if read["format"] != FORMAT:
        raise ValueError(f"{path}: format {read['format']!r}, {FORMAT!r} is read here")
    return read


def pose(record):
    return pin.SE3(np.array(record["R"], dtype=float), np.array(record["p"], dtype=float))


def touching_pose(contact, patch):
    """X_WC that a fixed contact asks for; a ball's middle is its radius over the touched point."""
    X = pose(contact)
    return X * pin.SE3(np.eye(3), np.array([0.0, 0.0, patch.radius]))


def thin_body(surface, thickness):
    """The convex body behind a surface."""
    X = pose(surface)
    flat = np.array(surface["polygon_m"], dtype=float)
    corners = [X.act(np.array([x, y, z])) for z in (0.0, -thickness) for x, y in flat]
    return convex_hull(np.array(corners))


def convex_hull(points):
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    used = {v: i for i, v in enumerate(hull.vertices)}
    vertices, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for v in hull.vertices:
        vertices.append(points[v])
    for simplex, equation in zip(hull.simplices, hull.equations):
        a, b, c = simplex
        if np.dot(np.cross(points[b] - points[a], points[c] - points[a]), equation[:3]) < 0.0:
            b, c = c, b
        triangles.append(coal.Triangle(used[a], used[b], used[c]))
    return coal.Convex(vertices, triangles)


def base_guess(robot, problem):
    """The resting posture, its base upright where the contacts would have it: yaw by least squares."""
    q = robot.resting()
    robot.place(q)
    surfaces = {s["id"]: s for s in problem.get("surfaces", [])}
    here, there, sin, cos = [], [], 0.0, 0.0
    for contact in problem["contacts"]:
        patch = robot.patch_of(contact)
        X = robot.X_WC(patch)
        target = pose(contact) if "p" in contact else pose(surfaces[contact["surface"]])
        here.append(X.translation)
        there.append(target.translation)
        level = X.rotation[2, 2] > 0.5 and target.rotation[2, 2] > 0.5
        if "p" in contact and not contact.get("yaw_free") and level:
            a, b = X.rotation[:2, 0], target.rotation[:2, 0]
            sin += 0.01 * (a[0] * b[1] - a[1] * b[0])
            cos += 0.01 * a @ b
    here, there = np.array(here), np.array(there)
    for a, b in zip(here - here.mean(0), there - there.mean(0)):
        sin += a[0] * b[1] - a[1] * b[0]
        cos += a[:2] @ b[:2]
    yaw = math.atan2(sin, cos)
    R = pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
    q[:3] = there.mean(0) - R @ (here.mean(0) - q[:3])
    q[3:7] = [0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)]
    return q
