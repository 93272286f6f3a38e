"""The package by itself: what it gives, what it refuses, and that it leaves the interpreter alive."""

from __future__ import annotations

import json
import signal
import threading
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import scandent
from conftest import ROOT, rectangle
from scandent import InputError

K = [[150.0, 0.0, 79.5], [0.0, 150.0, 59.5], [0.0, 0.0, 1.0]]
#: The optical frame 1 m over the ground, looking ahead along x.
T_WV = np.array([[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]])


def test_a_plan_is_arrays_in_equilibrium(climb: scandent.Plan, hrp2: scandent.Robot) -> None:
    motion, nj = climb.motion, len(hrp2.joint_names)
    assert motion is not None
    n = len(motion.t)
    shapes = [motion.q.shape, motion.v.shape, motion.a.shape, motion.tau.shape, motion.wrenches.shape]
    assert shapes == [(n, 7 + nj), (n, 6 + nj), (n, 6 + nj), (n, nj), (n, len(motion.patches), 6)]
    assert climb.certificate is not None and climb.certificate.passes
    # Newton: what bears and weight make the centre of mass accelerate, but where that jumps between samples.
    weight = 9.81 * hrp2.mass_kg
    force = np.nansum(motion.wrenches[:, :, :3], axis=1) - [0.0, 0.0, weight]
    a_com = np.diff(motion.com_W, n=2, axis=0) / motion.dt_s**2
    left = np.abs(force[1:-1] - hrp2.mass_kg * a_com).max(axis=1) / weight
    assert np.median(left) < 1e-3 and np.quantile(left, 0.95) < 0.02
    for stance in climb.stances:
        total = sum(forces.sum(axis=0) for forces in stance.forces.values())
        assert np.allclose(total, [0.0, 0.0, 9.81 * hrp2.mass_kg], atol=1.0)
    ends = [phase["t_end_s"] for phase in motion.phases]
    assert ends[-1] == pytest.approx(motion.duration_s)


def test_pinocchio_balances_a_motion(climb: scandent.Plan) -> None:
    pin = pytest.importorskip("pinocchio", reason="SKIPPED: no pinocchio (pip install pin)")
    urdf = ROOT / "scenes" / "robots" / "hrp2" / "hrp2.urdf"
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    data = model.createData()
    motion = climb.motion
    assert motion is not None
    theirs = scandent.pinocchio.trajectory(model, climb.joint_names, motion)
    bears = np.nansum(motion.wrenches, axis=1)
    for k in range(0, len(motion.t), 7):
        pin.forwardKinematics(model, data, theirs.q[k])
        needed = pin.rnea(model, data, theirs.q[k], theirs.v[k], theirs.a[k])
        assert np.allclose(data.oMi[1].rotation @ needed[:3], bears[k, :3], atol=0.01)
    assert theirs.tau.shape == (len(motion.t), model.nv) and not theirs.tau[:, :6].any()


def test_a_depth_image_becomes_faces(flat: npt.NDArray[np.uint16]) -> None:
    terrain = scandent.perceive(flat, K, T_WV)
    (face,) = terrain.faces
    assert np.allclose(face.normal_W, [-1.0, 0.0, 0.0], atol=1e-3)
    assert np.allclose(face.vertices_W[:, 0], 2.0, atol=1e-2)
    assert terrain.cloud_W.shape == (120 * 160, 3)
    seven = [0.0, 0.0, 1.0, -0.5, 0.5, -0.5, 0.5]
    assert scandent.perceive(flat, [150.0, 150.0, 79.5, 59.5], seven).to_json() == terrain.to_json()


def test_meshes_of_arrays_and_polygons_agree() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    mesh = scandent.Terrain.from_mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    flat = scandent.Terrain.from_polygons([corners])
    for terrain in (mesh, flat):
        (face,) = terrain.faces
        assert np.allclose(face.normal_W, [0, 0, 1])
        assert np.allclose(sorted(face.vertices_W.tolist()), sorted(corners.tolist()))


def test_faces_have_a_friction_of_their_own(hrp2: scandent.Robot) -> None:
    squares = {"floor": rectangle(-0.5, 0.45, 0.0), "step": rectangle(0.45, 1.4, 0.1)}
    icy = scandent.Terrain.from_polygons(squares, friction={"step": 0.05})
    assert [face.friction for face in icy.faces] == [None, 0.05]
    assert [face.friction for face in icy.with_friction(0.4).faces] == [0.4, 0.4]
    assert [face.friction for face in icy.faces] == [None, 0.05]
    # A tilted face holds a foot by its friction alone.
    turn = np.array([[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]])
    tilted = scandent.Terrain.from_polygons({"slope": np.asarray(rectangle(-0.5, 0.5, 0.0)) @ turn.T})
    both = {"right_foot": "slope", "left_foot": "slope"}
    assert scandent.solve_posture(hrp2, tilted, both).feasible
    assert not scandent.solve_posture(hrp2, tilted.with_friction(0.1), both).feasible
    for wrong in (0.0, float("nan"), {"roof": 0.5}, {"slope": -1.0}, "ice"):
        with pytest.raises(scandent.InputError) as caught:
            tilted.with_friction(wrong)  # type: ignore[arg-type]
        assert caught.value.argument is not None and caught.value.argument.startswith("friction")


def test_postures_on_a_terrain(step: scandent.Terrain, hrp2: scandent.Robot) -> None:
    found = scandent.solve_posture(hrp2, step, {"right_foot": "floor", "left_foot": "step"})
    assert found.feasible and found.q is not None
    assert sum(f.sum(axis=0) for f in found.forces.values())[2] == pytest.approx(9.81 * hrp2.mass_kg, rel=1e-3)
    far = np.eye(4)
    far[:3, 3] = [3.0, 0.0, 0.1]
    none = scandent.solve_posture(hrp2, step, {"right_foot": "floor", "left_foot": far})
    assert not none.feasible and none.reason and none.q is None


def test_many_postures_are_arrays(hrp2: scandent.Robot) -> None:
    problems = scandent.draw_postures(hrp2, "easy", 6, seed=3)
    found = scandent.solve_postures(hrp2, problems)
    assert len(found) == 6 and found.q.shape == (6, 7 + len(hrp2.joint_names))
    assert found.feasible.all() and found[0].margins["joint_rad"] > 0.0
    again = scandent.solve_postures(hrp2, json.loads(problems), threads=1)
    assert np.array_equal(found.q, again.q)


def test_no_plan_carries_its_reasons(hrp2: scandent.Robot) -> None:
    gap = scandent.Terrain.from_polygons({"here": rectangle(-0.5, 0.5, 0.0), "there": rectangle(3.5, 4.5, 0.0)})
    with pytest.raises(scandent.NoPlan) as caught:
        scandent.plan(gap, hrp2, goal=[4.0, 0.0])
    assert caught.value.status == "no_plan"
    assert "there" in " ".join(caught.value.reasons)
    assert isinstance(caught.value.partial, scandent.Plan)


def test_a_plan_goes_on_from_a_stance(hrp2: scandent.Robot) -> None:
    floor = scandent.Terrain.from_polygons({"floor": rectangle(-0.5, 2.0, 0.0)})
    found = scandent.plan(floor, hrp2, goal=[0.6, 0.0])
    on_one_foot = next(s for s in found.stances if sum(c.loaded for c in s.contacts) == 1)
    onward = scandent.plan(floor, hrp2, on_one_foot, goal=[1.2, 0.0])
    assert np.allclose(onward.stances[0].q, on_one_foot.q, atol=0.02)
    head = hrp2.joint_names.index("HEAD_JOINT0")
    looks = scandent.plan(floor, hrp2, goal=[0.6, 0.0], start_joints={"HEAD_JOINT0": 0.3})
    assert looks.stances[0].q[7 + head] == pytest.approx(0.3, abs=0.02)


def test_a_start_before_the_floor_that_is_seen(hrp2: scandent.Robot) -> None:
    floor = scandent.Terrain.from_polygons({"floor": rectangle(0.9, 3.0, 0.0)})
    found = scandent.plan(floor, hrp2, goal=[1.5, 0.0], goal_tolerance_m=0.2, before_floor=True)
    assert 0.6 < found.stances[0].q[0] < 0.9


def test_a_callback_stops_the_search_at_the_same_place(step: scandent.Terrain, hrp2: scandent.Robot) -> None:
    def stopped() -> list[int]:
        nodes: list[int] = []

        def progress(n: int, solved: int, distance_m: float, stage: str) -> bool:
            nodes.append(n)
            return n < 4

        with pytest.raises(scandent.Undecided) as caught:
            scandent.plan(step, hrp2, goal=[0.7, 0.0], progress=progress)
        assert caught.value.status == "interrupted"
        return nodes

    assert stopped() == stopped()

    def fails(*_: object) -> None:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        scandent.plan(step, hrp2, goal=[0.7, 0.0], progress=fails)


def test_ctrl_c_stops_and_other_threads_run(hrp2: scandent.Robot) -> None:
    problems = scandent.draw_postures(hrp2, "hard", 4)
    problems_400 = {**json.loads(problems), "problems": json.loads(problems)["problems"] * 400}
    many = json.dumps(problems_400).encode()
    ticks: list[float] = []
    done = threading.Event()

    def tick() -> None:
        while not done.wait(0.01):
            ticks.append(time.monotonic())
            if len(ticks) == 5:
                signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=tick)
    # In the background of a shell Python ignores what the keyboard says.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    thread.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            scandent.solve_postures(hrp2, many)
    finally:
        done.set()
        thread.join()
        signal.signal(signal.SIGINT, before)
    assert len(ticks) >= 5


def image(**changes: object) -> dict[str, object]:
    depth = np.full((120, 160), 2000, dtype=np.uint16)
    return {"depth": depth, "K": K, "T_WV": T_WV, **changes}


MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"depth": np.full((120, 160), 2.0, dtype=np.float32)}, "depth"),
        ({"depth": np.zeros((4, 4, 3), dtype=np.uint16)}, "depth"),
        ({"depth": np.zeros((0, 4), dtype=np.uint16)}, "depth"),
        ({"depth": np.zeros((120, 160), dtype=np.uint16)}, "depth"),
        ({"depth": [[1, 2], [3, 4]]}, "depth"),
        ({"depth": None}, "depth"),
        ({"K": np.eye(4)}, "K"),
        ({"K": [[np.nan, 0, 1], [0, 1, 1], [0, 0, 1]]}, "K"),
        ({"K": [-1.0, 1.0, 1.0, 1.0]}, "K"),
        ({"T_WV": None}, "T_WV"),
        ({"T_WV": np.zeros((4, 4))}, "T_WV"),
        ({"T_WV": MIRROR}, "T_WV"),
        ({"T_WV": np.full((4, 4), np.nan)}, "T_WV"),
        ({"T_WV": [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0]}, "T_WV"),
        ({"T_WV": "here"}, "T_WV"),
        ({"depth_scale_m": float("inf")}, "depth_scale_m"),
        ({"sensor": 3}, "sensor"),
        ({"config": {"perception": {"range_max_m": object()}}}, "config"),
        ({"threads": 0}, "threads"),
    ],
)
def test_images_that_make_no_sense_are_named(changes: dict[str, object], argument: str) -> None:
    with pytest.raises(InputError) as caught:
        scandent.perceive(**image(**changes))  # type: ignore[arg-type]
    assert caught.value.argument == argument and argument in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"goal": None}, "goal"),
        ({"goal": [1.0]}, "goal"),
        ({"goal": [1.0, float("nan")]}, "goal"),
        ({"goal": "there"}, "goal"),
        ({"start": "flying"}, "start"),
        ({"start": ("half_sitting", np.zeros((4, 4)))}, "start"),
        ({"start": {"tail": np.eye(4)}}, "start"),
        ({"start_contacts": ["tail"]}, "start_contacts"),
        ({"start_joints": {"tail": 0.1}}, "start_joints"),
        ({"goal_contacts": {"tail": "floor"}}, "goal_contacts"),
        ({"goal_posture": "flying"}, "goal_posture"),
        ({"goal_posture": {"tail": 0.1}}, "goal_posture"),
        ({"guide": [[1.0, 2.0]]}, "guide"),
        ({"friction": -1.0}, "friction"),
        ({"seed": -1}, "seed"),
        ({"seed": 1.5}, "seed"),
        ({"threads": 0}, "threads"),
        ({"config": {"planner": {"nodes_max": float("nan")}}}, "config"),
        ({"config": {"planner": {"no_such": 1}}}, "config"),
        ({"terrain": None}, "terrain"),
        ({"robot": "builtin:hrp2"}, "robot"),
        ({"progress": 3}, "progress"),
    ],
)
def test_questions_that_make_no_sense_are_named(
    changes: dict[str, object], argument: str, step: scandent.Terrain, hrp2: scandent.Robot
) -> None:
    asked = {"terrain": step, "robot": hrp2, "goal": [0.7, 0.0], **changes}
    with pytest.raises(InputError) as caught:
        scandent.plan(**asked)  # type: ignore[arg-type]
    assert caught.value.argument == argument


def test_robots_without_patches_and_files_that_are_none(tmp_path: Path, step: scandent.Terrain) -> None:
    urdf = tmp_path / "box.urdf"
    urdf.write_text(
        '<robot name="box"><link name="base"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    box = scandent.Robot.load(urdf)
    assert not box.patches and box.notes
    with pytest.raises(InputError) as caught:
        scandent.plan(step, box, goal=[1.0, 0.0])
    assert caught.value.argument == "robot" and "contacts=" in str(caught.value)
    for wrong in ("builtin:none", tmp_path / "none.urdf"):
        with pytest.raises(InputError):
            scandent.Robot.load(wrong)
    with pytest.raises(InputError):
        scandent.Robot.load(3)  # type: ignore[arg-type]
    for read in (scandent.Terrain.load, scandent.Terrain.from_mesh, scandent.Plan.load, scandent.verify):
        with pytest.raises(InputError):
            read(urdf)


def test_noise_raises_and_never_ends_the_interpreter(step: scandent.Terrain, hrp2: scandent.Robot) -> None:
    rng = np.random.default_rng(5)
    for _ in range(150):
        depth = rng.integers(0, 65536, size=rng.integers(1, 40, size=2)).astype(np.uint16)
        four = rng.normal(size=4) * 10.0 ** rng.integers(-300, 300)
        pose = np.concatenate([rng.normal(size=3) * 10.0 ** rng.integers(-5, 300), rng.normal(size=4)])
        pose[3:] /= np.linalg.norm(pose[3:])
        corners = rng.normal(size=(rng.integers(0, 6), 3)) * 10.0 ** rng.integers(-200, 200)
        for attempt in (
            lambda: scandent.perceive(depth, four, pose),
            lambda: scandent.perceive(depth, [50.0, 50.0, 10.0, 10.0], T_WV),
            lambda: scandent.Terrain.from_polygons([corners]),
            lambda: scandent.Terrain.from_mesh(corners, rng.integers(0, max(len(corners), 1), size=(4, 3))),
            lambda: scandent.solve_posture(hrp2, step, {"left_foot": pose}),
            lambda: scandent.solve_postures(hrp2, rng.bytes(30)),
            lambda: scandent.plan(step, hrp2, ("half_sitting", pose), pose[:2], config={"planner.nodes_max": 2}),
        ):
            try:
                attempt()
            except scandent.Error as error:
                assert "mistake in scandent" not in str(error), error


def test_the_simulation_is_of_the_wheel_that_is_asked_for() -> None:
    from scandent import _scandent

    for file in ("python/pyproject.toml", "python/requirements-test.txt"):
        assert f"mujoco=={_scandent.MUJOCO_VERSION}" in (ROOT / file).read_text()


def test_views_and_episodes(climb: scandent.Plan, tmp_path: Path) -> None:
    page = climb.view(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == page.html
    assert page._repr_html_().startswith("<iframe")
    assert climb.export("motion-csv").count(b"\n") == len(climb.motion.t) + 1  # type: ignore[union-attr]
    with pytest.raises(InputError, match="format"):
        climb.export("xml")
    scandent.datasets.save(climb, tmp_path / "climb.npz")
    read = scandent.datasets.load(tmp_path / "climb.npz")
    assert np.array_equal(read.q, climb.motion.q)  # type: ignore[union-attr]
    assert read.card == scandent.datasets.of_plan(climb).card and read.card["plan"] == climb.record
    assert len(read.terrain) == len(climb.record["faces"])
    assert np.allclose(read.q[read.stances_at][:, :3], read.stances_q[:, :3], atol=1e-3)
