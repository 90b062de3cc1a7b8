"""A stand-in of the part of rclpy that examples/ros2_node.py uses: topics within one process, delivered by `spin_once`.
Messages have the fields of the real definitions, by rosbags' copy of them, and refuse any other."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
from rosbags.typesys import Stores, get_typestore

DEFAULTS = {"string": "", "float64": 0.0, "bool": False}
MESSAGES = {
    "builtin_interfaces": ("Duration",),
    "sensor_msgs": ("Image", "JointState"),
    "trajectory_msgs": ("JointTrajectory", "JointTrajectoryPoint"),
}


class Wire:
    """What is between nodes: subscriptions by topic, messages on the way, and what else happens in a spin."""

    def __init__(self):
        self.subscriptions, self.queue, self.parameters = {}, [], {}
        self.on_spin = lambda: None

    def publish(self, topic, message):
        self.queue.append((topic, message))

    def spin_once(self, node, timeout_sec=None):
        self.on_spin()
        queue, self.queue = self.queue, []
        for topic, message in queue:
            for kind, callback in self.subscriptions.get(topic, []):
                assert isinstance(message, kind), f"{topic}: {type(message).__name__} and not {kind.__name__}"
                callback(message)


class Node:
    wire: Wire

    def __init__(self, name):
        self.name = name

    def declare_parameter(self, name, default):
        return SimpleNamespace(value=self.wire.parameters.get(name, default))

    def create_subscription(self, kind, topic, callback, qos):
        self.wire.subscriptions[topic] = [(kind, callback)]

    def create_publisher(self, kind, topic, qos):
        return SimpleNamespace(publish=lambda message: self.wire.publish(topic, message))

    def get_logger(self):
        return SimpleNamespace(info=print)

    def destroy_node(self):
        pass


def message_class(store, name):
    """A class that is made as rclpy's are: by keywords, with defaults, and without other attributes."""
    fields = dict(store.fielddefs[name][1])

    def __init__(self, **given):
        assert given.keys() <= fields.keys(), f"{name} has no {given.keys() - fields.keys()}"
        for field, (kind, what) in fields.items():
            plain = DEFAULTS.get(what[0] if isinstance(what, tuple) else what, 0) if kind.name == "BASE" else None
            setattr(self, field, given.get(field, [] if kind.name in ("ARRAY", "SEQUENCE") else plain))

    return type(name.rpartition("/")[2], (), {"__slots__": tuple(fields), "__init__": __init__})


def installed(monkeypatch):
    """Put the stand-ins in the place of rclpy and of the packages of messages → the wire."""
    wire, store = Wire(), get_typestore(Stores.ROS2_HUMBLE)

    def module(name, **members):
        made = ModuleType(name)
        vars(made).update(members)
        monkeypatch.setitem(sys.modules, name, made)

    module("rclpy", init=lambda: None, shutdown=lambda: None, spin_once=wire.spin_once)
    module("rclpy.node", Node=type("Node", (Node,), {"wire": wire}))
    module("rclpy.qos", qos_profile_sensor_data=object())
    for package, names in MESSAGES.items():
        module(package)
        module(f"{package}.msg", **{name: message_class(store, f"{package}/msg/{name}") for name in names})
    return wire


def image_message(kind, picture):
    """A sensor_msgs/Image of (height, width, 3) BGR, with padded rows as some drivers send."""
    height, width, _ = picture.shape
    rows = np.zeros((height, 3 * width + 5), np.uint8)
    rows[:, : 3 * width] = picture.reshape(height, -1)
    return kind(height=height, width=width, encoding="bgr8", step=rows.shape[1], data=rows.tobytes())
