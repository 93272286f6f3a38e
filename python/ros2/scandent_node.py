#!/usr/bin/env python3
"""A thin ROS 2 node about the package: a depth image and a goal become a joint trajectory.

    python3 scandent_node.py --ros-args -r depth:=/camera/depth/image_rect_raw -r camera_info:=/camera/depth/camera_info \\
        -p robot:=robot.urdf -p start:=half_sitting -p goal:="[2.0, 0.0]" -p sensor:=realsense_d4xx

Subscribes to `depth` (sensor_msgs/Image, 16UC1 in mm) and `camera_info`; the pose of the image's frame in `world` (parameter)
is tf's. The service `~/plan` (std_srvs/Trigger) plans from the last image, writes the results to `folder` and publishes the
motion on `~/trajectory` (trajectory_msgs/JointTrajectory, latched). Nothing moves a robot: who executes is another node.
"""

import numpy as np
import rclpy
import scandent
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger
from tf2_ros import Buffer, TransformException, TransformListener
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


class ScandentNode(Node):
    def __init__(self) -> None:
        super().__init__("scandent")
        given = {"robot": "builtin:hrp2", "start": "half_sitting", "goal": [2.0, 0.0], "sensor": "generic", "world": "world",
                 "folder": "out/ros2"}
        self.of = {name: self.declare_parameter(name, value).value for name, value in given.items()}
        self.robot = scandent.Robot.load(self.of["robot"])
        self.image = self.info = None
        self.tf = Buffer()
        self.listener = TransformListener(self.tf, self)
        self.create_subscription(Image, "depth", lambda message: setattr(self, "image", message), qos_profile_sensor_data)
        self.create_subscription(CameraInfo, "camera_info", lambda message: setattr(self, "info", message), qos_profile_sensor_data)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.trajectory = self.create_publisher(JointTrajectory, "~/trajectory", latched)
        self.create_service(Trigger, "~/plan", self.plan)

    def plan(self, _: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        try:
            plan = self.planned()
            answer.success, answer.message = True, repr(plan)
        except (scandent.Error, TransformException, ValueError) as error:
            answer.success, answer.message = False, str(error)
        return answer

    def planned(self) -> "scandent.Plan":
        image, info = self.image, self.info
        if image is None or info is None:
            raise ValueError("no depth image and camera_info yet")
        if image.encoding not in ("16UC1", "mono16"):
            raise ValueError(f"{image.encoding} images are not read; 16UC1 in mm is")
        order = ">u2" if image.is_bigendian else "<u2"
        rows = np.frombuffer(image.data, order).reshape(image.height, image.step // 2)
        depth = np.ascontiguousarray(rows[:, : image.width], np.uint16)
        seen = self.tf.lookup_transform(self.of["world"], image.header.frame_id, Time.from_msg(image.header.stamp), Duration(seconds=1))
        p, q = seen.transform.translation, seen.transform.rotation
        K = np.array(info.p).reshape(3, 4)[:, :3] if any(info.p) else np.array(info.k).reshape(3, 3)
        terrain = scandent.perceive(depth, K, [p.x, p.y, p.z, q.x, q.y, q.z, q.w], sensor=self.of["sensor"])
        plan = scandent.plan(terrain, self.robot, self.of["start"], goal=list(self.of["goal"]))
        plan.save(self.of["folder"])
        motion = plan.motion
        message = JointTrajectory(joint_names=list(plan.joint_names))
        message.header.stamp = self.get_clock().now().to_msg()
        for t, q_, v in zip(motion.t, motion.q, motion.v):
            at = Duration(seconds=float(t)).to_msg()
            message.points.append(JointTrajectoryPoint(positions=q_[7:].tolist(), velocities=v[6:].tolist(), time_from_start=at))
        self.trajectory.publish(message)
        return plan


def main() -> None:
    rclpy.init()
    rclpy.spin(ScandentNode())


if __name__ == "__main__":
    main()
