"""A scene as a file that a person edits: what each line means stands above it."""

import dataclasses
import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..sensing.files import MAX_NAME_CHARS, escape
from .robot import Robot, robot_names
from .scene import Eye, Scene, load_robot, load_scene, scene_names
from .urdf.reference import is_reference, parse_reference

BEFORE = {
    "robot": "The URDF, from this file; --robot names one elsewhere. After # may stand base=LINK&tip=LINK: where the\n"
    "# arm begins and ends",
    "moving_joints": "Those that imitate, by number",
    "range_deg": "How far they turn here, degrees",
    "posture_deg": "All joints at rest, degrees; the moving ones as the demonstrator stands",
    "start_deg": "Where the learner starts, the moving joints, degrees",
    "size": "How large the page draws what stands around the arms",
    "head": "The stereo head, m and px. It turns from one gaze to the other; all points must be in all four images",
    "demonstrator": "Where the arms stand, m, and how they are turned about the vertical",
    "points": "Layouts of body points, on what is seen of the arm, by their number: [link, x, y, z], m, in the frame\n"
    "# of the link that joint i moves (0 = base)",
}
USUAL = {"verged": False, "toe_in_deg": 0.0, "undistort": [0.0, 0.0]}  # of a head, which need not be said


def scene_file(fields: dict, robot: Robot, heading: str) -> str:
    """TOML. fields: of a scene; heading: the first line."""
    return "\n".join([f"# {heading}", *_lines(fields, robot)]) + "\n"


def saved_scene(scene: Scene, heading: str) -> str:
    """TOML of a scene as it is, for a file beside its URDF: of whose path only the last part is told."""
    fields = msgspec.to_builtins(scene)
    if is_reference(scene.robot):
        found = parse_reference(scene.robot)
        fields["robot"] = str(dataclasses.replace(found, path=Path(found.path.name)))
    return scene_file(fields, load_robot(scene.robot), heading)


def _lines(fields: dict, robot: Robot) -> Iterator[str]:
    tables = {name: value for name, value in fields.items() if isinstance(value, dict)}
    for name, value in fields.items():
        if name in tables:
            continue
        if name == "moving_joints":
            yield from _joints(robot)
        yield from _comment(name)
        yield f"{name} = {toml(value)}"
    for name, table in tables.items():
        yield ""
        yield from _comment(name)
        yield f"[{name}]"
        for key, value in table.items():
            if name == "points":
                yield f"{key} = ["
                yield from (f"  {toml(point)},  # {_link(robot, point[0])}" for point in value)
                yield "]"
            elif isinstance(value, dict):
                yield from _eye(f"{name}.{key}", value)
            elif USUAL.get(key) != (list(value) if isinstance(value, tuple) else value):
                yield f"{key} = {toml(value)}"


def _eye(name: str, fields: dict) -> Iterator[str]:
    """What a camera of the head has for itself; in the order of `Head`, after all that both have."""
    said = {key: value for key, value in fields.items() if value is not None and tuple(value) != Eye().distortion}
    if said:
        yield from ("", f"[{name}]", *(f"{key} = {toml(value)}" for key, value in said.items()))


def _comment(name: str) -> list[str]:
    return f"# {BEFORE[name]}".split("\n") if name in BEFORE else []


def _joints(robot: Robot) -> Iterator[str]:
    yield "# Joints, base to tip:"
    for number, joint in enumerate(robot.joints, 1):
        if joint.leader is not None:
            what = f"follows {joint.leader.joint + 1}"
        else:
            what = "{:.5g}° … {:.5g}°".format(*np.degrees((joint.lower, joint.upper)))
        yield f"#   {number} {escape(joint.name, MAX_NAME_CHARS)}: {what}"


def _link(robot: Robot, number: int) -> str:
    return f"moved by {escape(robot.joints[number - 1].name, MAX_NAME_CHARS)}" if number else "base"


def toml(value: Any) -> str:
    """Text, numbers, truth values, and lists of them."""
    if isinstance(value, str):
        quoted = json.dumps(value, ensure_ascii=False)
        return "".join(one if one.isprintable() else f"\\U{ord(one):08x}" for one in quoted)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.0f}" if value == int(value) else repr(value)


# A scene in few words, which need no file but those that are shipped: what it differs in from one of them.


def scene_text(scene: Scene) -> str:
    """For `load_scene`, which makes the very same scene of it. Raises ValueError for a robot that is not shipped, whose
    files no text holds."""
    if scene.robot not in robot_names():
        raise ValueError(
            f"its robot, {scene.robot}, is not among those that are everywhere, {', '.join(robot_names())}"
        )
    fields = msgspec.to_builtins(scene)
    told = [_difference({}, fields)]
    for name, below in _shipped().items():
        if _all_said(below, fields):
            told.append({"extends": name, "title": scene.title, **_difference(below, fields)})
    text = min(("\n".join(_toml_lines(one)) + "\n" for one in told), key=len)
    if load_scene(text) != scene:
        raise ValueError("it cannot be told in words")
    return text


@cache
def _shipped() -> dict[str, dict]:
    return {name: msgspec.to_builtins(load_scene(name)) for name in scene_names()}


def _all_said(below: dict, above: dict) -> bool:
    """Whether nothing is said below alone: a scene that extends another replaces what that says, and takes back
    nothing."""
    return all(
        above.get(name) is not None and (not isinstance(value, dict) or _all_said(value, above[name]))
        for name, value in below.items()
        if value is not None
    )


def _difference(below: dict, above: dict) -> dict:
    """What is other above, or only there."""
    found = {}
    for name, value in above.items():
        if isinstance(value, dict):
            value = _difference(below.get(name, {}), value)
        if value is not None and value != {} and value != below.get(name):
            found[name] = value
    return found


def _toml_lines(fields: dict, table: str = "") -> Iterator[str]:
    """TOML: values first, then tables."""
    tables = {name: value for name, value in fields.items() if isinstance(value, dict)}
    yield from (f"{name} = {toml(value)}" for name, value in fields.items() if name not in tables)
    for name, inside in tables.items():
        within = f"{table}.{name}" if table else name
        yield f"[{within}]"
        yield from _toml_lines(inside, within)
