"""The least time along the phases of a motion, by toppra and by Scandent's own law.

    cargo build --release -p scandent-motion --example path_time
    python pace.py FOLDER ROBOT.urdf        # FOLDER holds plan.json and motion.json

Both get the same paths of joints, resampled by their length, and the same limits of speed and
acceleration; Scandent's law also takes its mean over `smooth_s`. Exits 1 above 1.15 times toppra's time.
"""

import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import toppra
from scipy.interpolate import CubicSpline

TIME = Path(__file__).parents[2] / "target/release/examples/path_time"
SMOOTH_S = 0.05
PIECES = 80


def main(folder, urdf):
    plan = json.loads((folder / "plan.json").read_text())
    motion = json.loads((folder / "motion.json").read_text())
    limits = {j.get("name"): j.find("limit") for j in ET.parse(urdf).iter("joint")}
    names = plan["robot"]["joint_names"]
    use = motion["limits"]["joint_speed_use"]
    speeds = np.array([float(limits[name].get("velocity")) * use for name in names])
    acceleration = motion["limits"]["joint_acceleration_rad_s2"]
    sharp, smooth, peer = 0.0, 0.0, 0.0
    for phase in motion["phases"]:
        begin, end = (round(phase[k] / motion["dt_s"]) for k in ("t_start_s", "t_end_s"))
        joints = np.array([s["q"][7:] for s in motion["samples"][begin : end + 1]])
        if phase["kind"] == "hold":
            continue
        path = resampled(joints)
        asked = {"path": path.tolist(), "speeds": speeds.tolist(), "acceleration": acceleration}
        smooth += ours(asked | {"smooth_s": SMOOTH_S})
        sharp += ours(asked | {"smooth_s": 1e-6})
        peer += toppras(path, speeds, acceleration)
    print(f"toppra {peer:.3f} s; Scandent {sharp:.3f} s, smooth {smooth:.3f} s: {smooth / peer:.3f} times")
    return int(smooth > 1.15 * peer)


def resampled(joints):
    """The same path at equal steps of its length."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(joints, axis=0), axis=1))])
    apart = np.concatenate([[True], np.diff(length) > 1e-7])
    curve = CubicSpline(length[apart], joints[apart])
    return curve(np.linspace(0.0, length[apart][-1], PIECES + 1))


def ours(asked):
    ran = subprocess.run([TIME], input=json.dumps(asked), capture_output=True, text=True, check=True)
    return float(ran.stdout)


def toppras(path, speeds, acceleration):
    grid = np.linspace(0.0, 1.0, PIECES + 1)
    curve = toppra.SplineInterpolator(grid, path)
    bounds = [
        toppra.constraint.JointVelocityConstraint(np.stack([-speeds, speeds], axis=1)),
        toppra.constraint.JointAccelerationConstraint(
            np.full((len(speeds), 2), [-acceleration, acceleration]),
        ),
    ]
    algorithm = toppra.algorithm.TOPPRA(bounds, curve, gridpoints=np.linspace(0.0, 1.0, 2 * PIECES + 1))
    return algorithm.compute_trajectory(0.0, 0.0).duration


if __name__ == "__main__":
    toppra.setup_logging("ERROR")
    sys.exit(main(Path(sys.argv[1]), sys.argv[2]))
