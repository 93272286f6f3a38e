#!/usr/bin/env python3
"""Audits postures of any solver: is each a posture that solves its problem?

Reads q alone and finds forces of its own, so that no solver's word is taken. With Pinocchio and coal
for kinematics, torques and distances, and scipy's HiGHS for the linear program.

  contact      every patch at its pose (POSITION_M, ANGLE_RAD), or in its surface's plane and polygon
  limits       every joint within its limits (LIMIT_RAD)
  equilibrium  min t: forces at the patch vertices in friction cones (a pyramid of SIDES sides around the
               cone: at most 0.5 % too much) that balance the weight (to BALANCE of it, and m), with |tau_j| <= t tau_max_j
  torque       t <= 1 + TORQUE
  self         no two parts overlap, neighbours and the SRDF's pairs excepted
  environment  no part overlaps a surface's body; a link that touches may meet what lies behind its plane

  audit.py --urdf U --srdf S --contacts C PROBLEMS.json NAME=RESULTS.json …
"""

import argparse
import collections
import json
import math
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from robot import Robot, pose, read_problems, thin_body, touching_pose
from scipy.optimize import linprog

POSITION_M = 2e-3
ANGLE_RAD = 0.01
LIMIT_RAD = 1e-3
TORQUE = 1e-3
BALANCE = 1e-4
SIDES = 32
BEHIND_M = 0.015

CAUSES = ["contact", "limits", "equilibrium", "torque", "self", "environment"]


def contact_faults(robot, problem):
    """Patches that are not where their contacts are; the robot is placed."""
    surfaces = {s["id"]: s for s in problem.get("surfaces", [])}
    for contact in problem["contacts"]:
        patch = robot.patch_of(contact)
        X = robot.X_WC(patch)
        if "p" in contact:
            target = touching_pose(contact, patch)
            apart = np.linalg.norm(X.translation - target.translation)
            if patch.radius > 0.0:
                turned = 0.0
            elif contact.get("yaw_free"):
                turned = angle(X.rotation[:, 2], target.rotation[:, 2])
            else:
                turned = np.linalg.norm(pin.log3(X.rotation.T @ target.rotation))
            if apart > POSITION_M or turned > ANGLE_RAD:
                yield f"{patch.name}: {1e3 * apart:.1f} mm, {turned:.4f} rad off"
            continue
        surface = surfaces[contact["surface"]]
        X_WS = pose(surface)
        polygon = np.array(surface["polygon_m"], dtype=float)
        turned = 0.0 if patch.radius > 0.0 else angle(X.rotation[:, 2], X_WS.rotation[:, 2])
        if turned > ANGLE_RAD:
            yield f"{patch.name}: {turned:.4f} rad off the normal"
        for v in patch.vertices:
            p = X_WS.actInv(X.act(v))
            height = p[2] - patch.radius
            edges = np.roll(polygon, -1, axis=0) - polygon
            to = p[:2] - polygon
            inside = (edges[:, 0] * to[:, 1] - edges[:, 1] * to[:, 0]) / np.linalg.norm(edges, axis=1)
            if abs(height) > POSITION_M or inside.min() < -POSITION_M:
                yield f"{patch.name}: {1e3 * height:.1f} mm over its surface, {1e3 * inside.min():.1f} mm inside"
                break


def angle(a, b):
    return math.atan2(np.linalg.norm(np.cross(a, b)), a @ b)


def least_torque(robot, problem, q):
    """The least part of the torque limits that holds q; None where no forces balance the robot."""
    model, data = robot.model, robot.data
    gravity = pin.computeGeneralizedGravity(model, data, q)
    pin.computeJointJacobians(model, data, q)
    robot.place(q)
    surfaces = {s["id"]: s for s in problem.get("surfaces", [])}
    columns = []
    for contact in problem["contacts"]:
        patch = robot.patch_of(contact)
        X = robot.X_WC(patch)
        R, points = X.rotation, [X.act(v) for v in patch.vertices]
        if patch.radius > 0.0:
            R = np.array(contact["R"] if "R" in contact else surfaces[contact["surface"]]["R"], dtype=float)
            points = [X.translation - patch.radius * R[:, 2]]
        joint = robot.joint_of(patch)
        J_joint = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        around = problem["mu"] / math.cos(math.pi / SIDES)
        turns = 2.0 * math.pi * np.arange(SIDES) / SIDES
        edges = R @ np.vstack([around * np.cos(turns), around * np.sin(turns), np.ones(SIDES)])
        for p in points:
            J = J_joint[:3] - pin.skew(p - data.oMi[joint].translation) @ J_joint[3:]
            columns.append(J.T @ edges)
    G = np.hstack(columns) * robot.weight
    n = G.shape[1]
    # Rows of the floating base balance; rows of the joints stay within t of their limits.
    base, wanted = np.hstack([G[:6] / robot.weight, np.zeros((6, 1))]), gravity[:6] / robot.weight
    limited = np.isfinite(robot.effort) & (robot.effort > 0.0)
    scale = robot.effort[limited][:, None]
    tau, own = G[6:][limited] / scale, gravity[6:][limited] / scale[:, 0]
    ones = np.ones((len(own), 1))
    A = np.vstack([np.hstack([-tau, -ones]), np.hstack([tau, -ones]), base, -base])
    b = np.concatenate([-own, own, wanted + BALANCE, BALANCE - wanted])
    cost = np.zeros(n + 1)
    cost[-1] = 1.0
    result = linprog(cost, A, b, bounds=[(0.0, None)] * (n + 1), method="highs")
    return result.x[-1] if result.status == 0 else None


def environment_faults(robot, problem, body_m):
    """Parts of the robot in the bodies behind surfaces; the robot is placed."""
    surfaces = problem.get("surfaces", [])
    if not surfaces:
        return
    bodies = [thin_body(s, body_m) for s in surfaces]
    X_WS = {s["id"]: pose(s) for s in surfaces}
    corners = [[pose(s).act(np.array([x, y, z])) for x, y in s["polygon_m"] for z in (0.0, -body_m)] for s in surfaces]
    # Which joint's links may meet which bodies: those behind a plane that they touch.
    excepted = set()
    for contact in problem["contacts"]:
        if "surface" in contact:
            X = X_WS[contact["surface"]]
            joint = robot.joint_of(robot.patch_of(contact))
            for k, points in enumerate(corners):
                if all(X.actInv(p)[2] <= BEHIND_M for p in points):
                    excepted.add((joint, k))
    request = coal.CollisionRequest()
    for shape in robot.geometry.geometryObjects:
        X_WG = robot.data.oMi[shape.parentJoint] * shape.placement
        for k, body in enumerate(bodies):
            if (shape.parentJoint, k) in excepted:
                continue
            result = coal.CollisionResult()
            at = coal.Transform3s(X_WG.rotation, X_WG.translation)
            if coal.collide(shape.geometry, at, body, coal.Transform3s(), request, result):
                yield f"{shape.name} in {surfaces[k]['id']}"


def audit(robot, problem, q, body_m):
    """Cause -> what is wrong; empty where the posture solves the problem."""
    faults = {}
    robot.place(q)
    if found := list(contact_faults(robot, problem)):
        faults["contact"] = "; ".join(found)
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    beyond = np.maximum(low - q[7:], q[7:] - high)
    if beyond.max() > LIMIT_RAD:
        faults["limits"] = f"{robot.joint_names[int(beyond.argmax())]} by {beyond.max():.4f} rad"
    least = least_torque(robot, problem, q)
    if least is None:
        faults["equilibrium"] = "no forces balance the robot"
    elif least > 1.0 + TORQUE:
        faults["torque"] = f"{100.0 * least:.1f} % of a limit"
    if found := robot.colliding(q):
        faults["self"] = "; ".join(f"{a} - {b}" for a, b in found)
    robot.place(q)
    if found := list(environment_faults(robot, problem, body_m)):
        faults["environment"] = "; ".join(found)
    return faults


def quantile(values, part):
    values = sorted(values)
    return values[max(math.ceil(part * len(values)) - 1, 0)] if values else float("nan")


def audit_results(robot, problems, path):
    """One row for the table and the faults of each problem."""
    results = json.loads(Path(path).read_text())
    by_id = {json.dumps(p["id"]): p for p in problems["problems"]}
    names = results["joint_names"]
    causes, faults_of, times = collections.Counter(), {}, {True: [], False: []}
    claimed = valid = but_self = wrong = 0
    for result in results["results"]:
        problem = by_id[json.dumps(result["id"])]
        solved = result["outcome"] == "feasible"
        times[solved].append(result["us"])
        if not solved:
            wrong += problem.get("expected") == "solvable"
            continue
        claimed += 1
        q = robot.configuration(np.array(result["q"]), names)
        faults = audit(robot, problem, q, problems.get("body_m", 0.03))
        valid += not faults
        but_self += not set(faults) - {"self"}
        causes.update(faults.keys())
        if faults:
            faults_of[str(result["id"])] = faults
    return {
        "claimed": claimed,
        "valid": valid,
        "valid_but_self": but_self,
        "missed": wrong,
        "of": len(results["results"]),
        "causes": {c: causes[c] for c in CAUSES if causes[c]},
        "ms_solved": [quantile(times[True], 0.5) / 1e3, quantile(times[True], 0.95) / 1e3],
        "ms_failed": [quantile(times[False], 0.5) / 1e3, quantile(times[False], 0.95) / 1e3],
        "faults": faults_of,
    }


def print_table(rows):
    head = ["solver", "claimed", "all valid", "but self", "ms solved 50/95 %", "ms failed 50/95 %", "faults"]
    table = [head]
    for name, row in rows.items():
        of = row["of"]
        ms = lambda pair: " / ".join("–" if math.isnan(x) else f"{x:.3g}" for x in pair)
        causes = ", ".join(f"{k} {v}" for k, v in row["causes"].items()) or "none"
        cells = [name, f"{row['claimed']}/{of}", f"{row['valid']}/{of}", f"{row['valid_but_self']}/{of}"]
        table.append([*cells, ms(row["ms_solved"]), ms(row["ms_failed"]), causes])
    widths = [max(len(r[i]) for r in table) for i in range(len(head))]
    for r in table:
        print("  ".join(cell.ljust(w) for cell, w in zip(r, widths)).rstrip())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--urdf", required=True)
    parser.add_argument("--srdf")
    parser.add_argument("--contacts", required=True)
    parser.add_argument("--faults", help="write what is wrong with which posture here")
    parser.add_argument("--witnesses", action="store_true", help="audit the problems' own witnesses, too")
    parser.add_argument("problems")
    parser.add_argument("results", nargs="*", metavar="NAME=RESULTS.json")
    args = parser.parse_intermixed_args()
    robot = Robot(args.urdf, args.srdf, args.contacts)
    problems = read_problems(args.problems)
    if robot.at_rest:
        print("shapes that overlap at rest and are not watched:", robot.at_rest)
    if args.witnesses:
        print_witnesses(robot, problems)
    rows = {}
    for named in args.results:
        name, _, path = named.partition("=")
        rows[name] = audit_results(robot, problems, path)
    if rows:
        print_table(rows)
    if args.faults:
        Path(args.faults).write_text(json.dumps(rows, indent=1))


def print_witnesses(robot, problems):
    """Whether the postures that prove the problems solvable pass the same audit."""
    audited = [p for p in problems["problems"] if p.get("witness")]
    bad = {}
    for problem in audited:
        q = robot.configuration(np.array(problem["witness"]), problems["joint_names"])
        if faults := audit(robot, problem, q, problems.get("body_m", 0.03)):
            bad[problem["id"]] = faults
    print(f"witnesses: {len(audited) - len(bad)} of {len(audited)} valid", bad or "")


if __name__ == "__main__":
    main()
