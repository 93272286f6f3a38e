"""Bags that another library writes are read, and recordings of plans are read by it."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

import jsonschema
import numpy as np
import numpy.typing as npt
import pytest
from conftest import ROOT
from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer
from PIL import Image

import scandent

Program = Callable[..., str]
STAMP = {"sec": 1700000000, "nanosec": 250000000}
CLOCK = STAMP["sec"] * 10**9 + STAMP["nanosec"]
K = [365.3, 365.3, 254.7, 208.5]

HEADER = """
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
IMAGE = """std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
"""
INFO = """std_msgs/Header header
uint32 height
uint32 width
string distortion_model
float64[] d
float64[9] k
float64[9] r
float64[12] p
uint32 binning_x
uint32 binning_y
sensor_msgs/RegionOfInterest roi
"""
ROI = """
================================================================================
MSG: sensor_msgs/RegionOfInterest
uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
"""
TF = """geometry_msgs/TransformStamped[] transforms
================================================================================
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
================================================================================
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""


def bag(file: Path, depth: npt.NDArray[np.uint16], how: CompressionType, pose: List[float]) -> None:
    """A bag of a depth image (mm), its CameraInfo, and its pose in ``odom`` over a moving base."""
    height, width = depth.shape
    header = {"stamp": STAMP, "frame_id": "camera_optical"}
    fx, fy, cx, cy = K
    with file.open("wb") as out:
        writer = Writer(out, compression=how)
        image = writer.register_msgdef("sensor_msgs/msg/Image", IMAGE + HEADER)
        info = writer.register_msgdef("sensor_msgs/msg/CameraInfo", INFO + HEADER + ROI)
        tf = writer.register_msgdef("tf2_msgs/msg/TFMessage", TF + HEADER)

        def transform(topic: str, parent: str, child: str, ns: int, values: List[float]) -> None:
            stamp = {"sec": ns // 10**9, "nanosec": ns % 10**9}
            moved = {
                "header": {"stamp": stamp, "frame_id": parent},
                "child_frame_id": child,
                "transform": {"translation": dict(zip("xyz", values)), "rotation": dict(zip("xyzw", values[3:]))},
            }
            writer.write_message(topic, tf, {"transforms": [moved]}, log_time=ns)

        transform("/tf_static", "base", "camera_optical", CLOCK - 10**9, pose)
        for k in (-1, 1):
            transform("/tf", "odom", "base", CLOCK + k * 10**7, [0.02 * k, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        writer.write_message(
            "/camera/depth/camera_info",
            info,
            {
                "header": header,
                "height": height,
                "width": width,
                "distortion_model": "plumb_bob",
                "d": [0.0] * 5,
                "k": [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
                "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
                "p": [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
                "binning_x": 0,
                "binning_y": 0,
                "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
            },
            log_time=CLOCK,
        )
        raw: Dict[str, Any] = {
            "header": header,
            "height": height,
            "width": width,
            "encoding": "16UC1",
            "is_bigendian": 0,
            "step": 2 * width,
            "data": depth.astype("<u2").tobytes(),
        }
        writer.write_message("/camera/depth/image_raw", image, raw, log_time=CLOCK)
        writer.finish()


def same_planes(found: str, wanted: str) -> None:
    """That two files of surfaces have the same planes. (Of two poses that differ by rounding a cell at the edge of a face
    may count to another one, and edges and middles move by as much.)"""
    faces = [json.loads(text)["faces"] for text in (found, wanted)]
    assert [face["id"] for face in faces[0]] == [face["id"] for face in faces[1]]
    for one, other in zip(*faces):
        (p, normal), (p_other, normal_other) = (plane(face["X_WF"]) for face in (one, other))
        assert normal @ normal_other > 1.0 - 1e-6
        assert abs(normal @ (p - p_other)) < 1e-3


def plane(pose: Dict[str, List[float]]) -> Tuple[Any, Any]:
    x, y, z, w = pose["quat_xyzw"]
    return np.array(pose["p"]), np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


@pytest.fixture(scope="module")
def scan() -> Path:
    shared = Path(os.environ.get("SCANDENT_SHARED", ROOT / "../shared"))
    file = shared / "scans/rgbd/k2_stairs_0001_depth.png"
    if not file.exists():
        pytest.skip(f"SKIPPED: {file} is not there")
    return file.resolve()


def test_a_bag_is_its_image(program: Program, tmp_path: Path, scan: Path) -> None:
    depth = np.array(Image.open(scan)).astype(np.uint16)
    sensor, calibration = "--sensor=kinect_v2", ",".join(map(str, K))
    pose = [0.1, 0.0, 1.1, -0.6, 0.6, -0.38, 0.37]
    length = float(np.linalg.norm(pose[3:]))
    pose = pose[:3] + [x / length for x in pose[3:]]

    def result(name: str, *flags: object) -> str:
        program("surfaces", *flags, "-o", name, cwd=tmp_path)
        return (tmp_path / name).read_text()

    posed = result("posed.json", scan, f"{sensor}:{calibration}", f"--pose={','.join(map(repr, pose))}")
    level = result("level.json", scan, f"{sensor}:{calibration}", "--level")
    for how in (CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE):
        bag(tmp_path / "bag.mcap", depth, how, pose)
        # The base moves evenly: half way between its two places it is at the origin, but for rounding.
        same_planes(result("bag.json", "bag.mcap", sensor), posed)
        assert result("bag.json", "bag.mcap", sensor, "--level") == level

    flags = ["--level", "--goal=0.45,0", "--friction=0.6", "--robot=builtin:hrp2"]
    plans = []
    for name, scanned in (("png", [scan, f"{sensor}:{calibration}"]), ("bag", ["bag.mcap", sensor])):
        program("plan", "--scan", *scanned, *flags, "-o", name, cwd=tmp_path)
        plans.append(json.loads((tmp_path / name / "plan.json").read_text())["stances"])
    assert plans[0] == plans[1]


def test_a_recording_of_a_plan_is_as_its_schemas_say(climb: scandent.Plan) -> None:
    motion = climb.motion
    assert motion is not None
    reader = make_reader(io.BytesIO(climb.export("mcap")), validate_crcs=True)
    of_topic: Dict[str, List[Any]] = {}
    for schema, channel, message in reader.iter_messages():
        assert schema is not None and (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        if channel.topic not in of_topic:
            jsonschema.Draft202012Validator.check_schema(json.loads(schema.data))
        value = json.loads(message.data)
        jsonschema.validate(value, json.loads(schema.data))
        of_topic.setdefault(channel.topic, []).append((message.log_time * 1e-9, schema.name, value))

    joints = of_topic["/joint_states"]
    assert np.allclose([t for t, _, _ in joints], motion.t, atol=1e-9)
    assert np.allclose([value["position"] for _, _, value in joints], motion.q[:, 7:], atol=1e-6)
    assert joints[0][2]["name"] == climb.record["robot"]["joint_names"]

    # The base is where the motion has it, and every body has a shape or none in a frame that tf knows.
    frames = of_topic["/tf"]
    for t, _, value in frames:
        base = value["transforms"][0]["translation"]
        q = motion.q[int(np.argmin(np.abs(motion.t - t)))]
        assert np.allclose([base[axis] for axis in "xyz"], q[:3], atol=1e-6)
    assert frames[-1][0] == pytest.approx(motion.t[-1])
    known = {moved["child_frame_id"] for moved in frames[0][2]["transforms"]}
    assert {entity["frame_id"] for entity in of_topic["/robot"][0][2]["entities"]} == known
    world = {entity["id"] for entity in of_topic["/world"][0][2]["entities"]}
    assert {"floor", "step"} <= world

    # Forces hold the weight up where the robot rests, and every contact has its outline.
    _, _, value = of_topic["/contacts"][0]
    (drawn,) = value["entities"]
    newtons = sum(1e3 * (arrow["shaft_length"] + arrow["head_length"]) for arrow in drawn["arrows"])
    assert newtons >= 9.8 * climb.record["robot"]["mass_kg"]
    assert len(drawn["lines"]) == len(drawn["arrows"]) == len(climb.record["stances"][0]["contacts"])
    attached = [a for a in reader.iter_attachments()]
    assert json.loads(attached[0].data) == climb.record
    assert climb.export("mcap") == climb.export("mcap")


def test_rerun_is_given_the_motion(climb: scandent.Plan, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="SKIPPED: no rerun (pip install rerun-sdk)")
    chunk = pytest.importorskip("rerun.chunk")
    motion, file = climb.motion, tmp_path / "plan.rrd"
    assert motion is not None
    climb.to_rerun(file).disconnect()
    base: List[Any] = []
    links = set()
    for part in chunk.RrdReader(str(file)).stream().to_chunks():
        links.add(str(part.entity_path))
        if str(part.entity_path) == "/world/BODY":
            rows = part.to_record_batch()
            moved = rows.column("Transform3D:translation").to_pylist()
            base += zip(rows.column("time").cast("int64").to_pylist(), [place[0] for place in moved])
    times, places = zip(*sorted(base))
    np.testing.assert_allclose(places[-1], motion.q[-1, :3], atol=1e-5)
    assert times[-1] * 1e-9 == pytest.approx(motion.duration_s, abs=1e-3)
    assert {"/joints/position", "/phase", "/world/contacts/contacts/arrows", "/world/BODY/shape/cubes"} <= links
    assert any(one.startswith("/world/world/") and one.endswith("/triangles") for one in links)
