"""A ROS 2 node that imitates: it reads two cameras and the joint states, and sends trajectories of one point.

    ros2 run … or: python examples/ros2_node.py --ros-args -p joints:="[joint2, joint4]" \\
        -p lower_deg:="[-100.0, -170.0]" -p upper_deg:="[100.0, -10.0]" -p start_deg:="[20.0, -50.0]"

Both arms wear the markers of `viewimit markers`, and both cameras see both arms. Remap the topics to yours:

    left/image_raw, right/image_raw     sensor_msgs/Image, of 8 bits
    joint_states                        sensor_msgs/JointState
    joint_trajectory                    trajectory_msgs/JointTrajectory, which a joint_trajectory_controller takes

Run it with the arm stopped and a hand at the emergency stop: `max_step_deg` is how far a joint turns in one motion.
"""

import time

import numpy as np
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image, JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from viewimit import FourViews, Session
from viewimit.sensing.detection import FIRST_OF_DEMONSTRATOR, Fiducials

CHANNELS = {"mono8": 1, "rgb8": 3, "bgr8": 3}
PERIOD_S, TIMEOUT_S = 0.05, 30.0
AT_REST_RAD_S = 0.01


class Robot(Node):
    """Arm and eyes at once, see `viewimit.Arm` and `viewimit.Eyes`."""

    def __init__(self) -> None:
        super().__init__("viewimit")
        given = {
            name: self.declare_parameter(name, default).value
            for name, default in (
                ("joints", ["joint2", "joint4"]),
                ("lower_deg", [-100.0, -170.0]),
                ("upper_deg", [100.0, -10.0]),
                ("start_deg", [20.0, -50.0]),
                ("motion_s", 4.0),
                ("tolerance_deg", 0.5),
                ("noise_px", 0.1),
                ("dictionary", "4X4_50"),
            )
        }
        self.joints, self.noise_px, self.motion_s = list(given["joints"]), given["noise_px"], given["motion_s"]
        self.lower, self.upper, self.start = (
            np.radians(given[name]) for name in ("lower_deg", "upper_deg", "start_deg")
        )
        self.tolerance, self.markers = np.radians(given["tolerance_deg"]), Fiducials(given["dictionary"])
        self.images: dict[str, Image] = {}
        self.state: JointState | None = None
        for side in ("left", "right"):
            keep = lambda image, side=side: self.images.update({side: image})
            self.create_subscription(Image, f"{side}/image_raw", keep, qos_profile_sensor_data)
        self.create_subscription(JointState, "joint_states", lambda state: setattr(self, "state", state), 10)
        self.command = self.create_publisher(JointTrajectory, "joint_trajectory", 10)

    def move(self, theta):
        """Send the joints to angles, (m,) rad, and return where they are at rest."""
        seconds = int(self.motion_s)
        after = Duration(sec=seconds, nanosec=int(1e9 * (self.motion_s - seconds)))
        point = JointTrajectoryPoint(positions=theta.tolist(), time_from_start=after)
        self.command.publish(JointTrajectory(joint_names=self.joints, points=[point]))
        self.wait_for(lambda: self.is_at(theta), f"the joints to come to {np.degrees(theta).round(1)} degrees")
        return self.angles()

    def look(self):
        """Return the markers of both arms in a pair of pictures that are both taken now."""
        self.images.clear()
        self.wait_for(lambda: len(self.images) == 2, "a picture of each camera")
        left, right = (self.markers.detect(picture_of(self.images[side])) for side in ("left", "right"))
        numbers, unseen = range(FIRST_OF_DEMONSTRATOR), np.full(2, np.nan)
        return FourViews.from_images(
            *(
                [seen.get(first + k, unseen) for k in numbers]
                for first in (FIRST_OF_DEMONSTRATOR, 0)
                for seen in (left, right)
            )
        )

    def angles(self):
        """(m,) rad, measured."""
        assert self.state is not None  # `move` has waited for it
        return np.array([self.state.position[self.state.name.index(joint)] for joint in self.joints])

    def is_at(self, theta) -> bool:
        """Whether the joints rest near these angles. A driver that tells no velocities is believed to rest."""
        if self.state is None or not set(self.joints) <= set(self.state.name):
            return False
        speeds = [
            self.state.velocity[self.state.name.index(joint)] for joint in self.joints if len(self.state.velocity)
        ]
        rests = bool((np.abs(speeds) < AT_REST_RAD_S).all())
        return rests and bool((np.abs(self.angles() - theta) < self.tolerance).all())

    def wait_for(self, has_come, what: str) -> None:
        """Spin until has_come() is true. Raises TimeoutError."""
        until = time.monotonic() + TIMEOUT_S
        while not has_come():
            if time.monotonic() > until:
                raise TimeoutError(f"waited {TIMEOUT_S:g} s for {what}: check the topics with ros2 topic hz")
            rclpy.spin_once(self, timeout_sec=PERIOD_S)


def picture_of(image: Image):
    """(height, width, channels) uint8 of a message. Raises ValueError for an encoding that is not of 8 bits."""
    channels = CHANNELS.get(image.encoding)
    if channels is None:
        raise ValueError(f"pictures of encoding {image.encoding!r}: convert them to one of {', '.join(CHANNELS)}")
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
    return rows[:, : image.width * channels].reshape(image.height, image.width, channels).copy()


def main() -> None:
    rclpy.init()
    robot = Robot()
    step = robot.declare_parameter("max_step_deg", 10.0).value
    session = Session.of(robot, robot, frames=5, max_step_deg=step)
    report = lambda now: robot.get_logger().info(f"motion {now.motion}: E {now.E:.3f} px², {now.usable.sum()} points")
    result = session.run(each=report)
    robot.get_logger().info(f"{result.status}: {result.message}")
    robot.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
