"""A stand-in of the part of rclpy that examples/ros2_node.py uses. It is no ROS: nothing is serialised or sent.

Messages have the fields of the real definitions, by rosbags' copy of them, and refuse any other. Topics deliver when
`spin_once` is called, to the subscriptions of the same process.
"""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
from rosbags.typesys import Stores, get_typestore

DEFAULTS = {"string": "", "float64": 0.0, "bool": False}


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


def message_class(store, name):
    """A class that is made as rclpy's are: by keywords, with defaults, and without other attributes."""
    fields = store.fielddefs[name][1]

    def __init__(self, **given):
        unknown = given.keys() - {field for field, _ in fields}
        assert not unknown, f"{name} has no {unknown}"
        for field, (kind, what) in fields:
            default = [] if kind.name in ("ARRAY", "SEQUENCE") else None
            if default is None and kind.name == "BASE":
                default = DEFAULTS.get(what[0] if isinstance(what, tuple) else what, 0)
            setattr(self, field, given.get(field, default))

    slots = tuple(field for field, _ in fields)
    return type(name.rpartition("/")[2], (), {"__slots__": slots, "__init__": __init__})


def installed(monkeypatch):
    """Put the stand-ins in the place of rclpy and of the packages of messages → the wire."""
    wire, store = Wire(), get_typestore(Stores.ROS2_HUMBLE)

    class Node:
        def __init__(self, name):
            self.logged = []

        def declare_parameter(self, name, default):
            return SimpleNamespace(value=wire.parameters.get(name, default))

        def create_subscription(self, kind, topic, callback, qos):
            wire.subscriptions.setdefault(topic, []).append((kind, callback))

        def create_publisher(self, kind, topic, qos):
            return SimpleNamespace(publish=lambda message: wire.publish(topic, message))

        def get_logger(self):
            return SimpleNamespace(info=self.logged.append)

        def destroy_node(self):
            pass

    def module(name, **members):
        made = ModuleType(name)
        vars(made).update(members)
        monkeypatch.setitem(sys.modules, name, made)

    module("rclpy", init=lambda: None, shutdown=lambda: None, spin_once=wire.spin_once)
    module("rclpy.node", Node=Node)
    module("rclpy.qos", qos_profile_sensor_data=object())
    for package, names in {
        "builtin_interfaces": ("Duration",),
        "sensor_msgs": ("Image", "JointState"),
        "trajectory_msgs": ("JointTrajectory", "JointTrajectoryPoint"),
    }.items():
        module(package)
        module(f"{package}.msg", **{name: message_class(store, f"{package}/msg/{name}") for name in names})
    return wire


def image_message(kind, picture):
    """A sensor_msgs/Image of (height, width, 3) BGR, with padded rows as some drivers send."""
    height, width, _ = picture.shape
    step = 3 * width + 5
    rows = np.zeros((height, step), np.uint8)
    rows[:, : 3 * width] = picture.reshape(height, -1)
    return kind(height=height, width=width, encoding="bgr8", step=step, data=rows.tobytes())
