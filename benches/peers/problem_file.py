"""A peer's way through a file of problems: each solved and timed, the results written."""

import argparse
import json
import sys
import time
from pathlib import Path

from robot import Robot, read_problems


def solve_file(name, doc, Solver):
    """Runs `Solver(robot).solve(problem, number)`, a q or None, over the file that the arguments name."""
    parser = argparse.ArgumentParser(description=doc)
    for flag in ("--urdf", "--srdf", "--contacts", "-o"):
        parser.add_argument(flag, required=True)
    parser.add_argument("problems")
    args = parser.parse_args()
    robot = Robot(args.urdf, args.srdf, args.contacts)
    solver = Solver(robot)
    results = []
    for number, problem in enumerate(read_problems(args.problems)["problems"]):
        begin = time.perf_counter()
        q = solver.solve(problem, number)
        us = 1e6 * (time.perf_counter() - begin)
        outcome = "undecided" if q is None else "feasible"
        results.append({"id": problem["id"], "outcome": outcome, "q": q, "us": us})
        print(f"{name} {problem['id']}: {outcome}, {us / 1e3:.0f} ms", file=sys.stderr)
    Path(args.o).write_text(json.dumps({"joint_names": robot.joint_names, "results": results}))
