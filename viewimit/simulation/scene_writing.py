"""Write scenes: as a commented TOML file for a person to edit, and as a short text that needs only shipped files."""

import dataclasses
import json
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..sensing.files import MAX_NAME_CHARS, escape
from .robot import Robot, load_robot, robot_names
from .scene import Head, Scene, load_scene, scene_names
from .urdf.reference import is_reference, parse_reference

COMMENTS = {  # before a field or table
    "robot": "The URDF, from this file; --robot names one elsewhere. #base=LINK&tip=LINK&meshes=FOLDER may follow:\n"
    "# the first and the last link of the arm, and a further folder of meshes",
    "moving_joints": "Joints that imitate, by number",
    "range_deg": "Their ranges in this scene, degrees",
    "posture_deg": "All joints at rest, degrees; the moving ones at the demonstrator's start",
    "start_deg": "The moving joints at the learner's start, degrees",
    "size": "Scale of the page's drawings around the arms",
    "head": "The stereo head, m and px. It turns from one gaze to the other; all points must be in all four images",
    "demonstrator": "Where the arms stand, m, and their rotation about the vertical, degrees",
    "points": "Layouts of body points on visible surfaces, by their number: [link, x, y, z], m, in the frame of\n"
    "# the link that joint i moves (0 = base)",
}
_DEFAULTS = ((field.name, field.default) for field in msgspec.structs.fields(Head))
HEAD = {name: msgspec.to_builtins(default) for name, default in _DEFAULTS if default is not msgspec.NODEFAULT}


def scene_file(fields: dict[str, Any], robot: Robot, heading: str) -> str:
    """Return a scene's fields as commented TOML, with a heading in the first line, without what is usual of a head."""
    unusual = {**_difference({"head": HEAD}, fields), "points": fields["points"]}
    return "\n".join([f"# {heading}", *_lines(unusual, robot)]) + "\n"


def saved_scene(scene: Scene, heading: str) -> str:
    """Return a scene as commented TOML, for a file beside its URDF. Of the URDF's path it has the last part only."""
    fields = msgspec.to_builtins(scene)
    if is_reference(scene.robot):
        found = parse_reference(scene.robot)
        meshes = None if found.meshes is None else Path(os.path.relpath(found.meshes, found.path.parent))
        fields["robot"] = str(dataclasses.replace(found, path=Path(found.path.name), meshes=meshes))
    return scene_file(fields, load_robot(scene.robot), heading)


def scene_text(scene: Scene) -> str:
    """Return a short text from which `load_scene` makes the same scene: the differences from a shipped scene.

    Raises ValueError for a robot that is not shipped, because no text holds its files.
    """
    if scene.robot not in robot_names():
        everywhere = ", ".join(robot_names())
        raise ValueError(f"its robot, {scene.robot}, is not among those that are everywhere, {everywhere}")
    fields = msgspec.to_builtins(scene)
    candidates = [whole_text(scene)]
    for name, below in _shipped_fields().items():
        if _only_adds(below, fields):
            added = {"extends": name, "title": scene.title, **_difference(below, fields)}
            candidates.append("\n".join(_lines(added)) + "\n")
    text = min(candidates, key=len)
    if load_scene(text) != scene:
        raise ValueError("no text reproduces it")
    return text


def whole_text(scene: Scene) -> str:
    """Return all fields of a scene as a text, which a scene of a shipped robot can be loaded from anywhere."""
    return "\n".join(_lines(_difference({}, msgspec.to_builtins(scene)))) + "\n"


def toml(value: Any) -> str:
    """Return text, numbers, booleans and lists of them as a TOML value."""
    if isinstance(value, str):
        quoted = json.dumps(value, ensure_ascii=False)
        return "".join(one if one.isprintable() else f"\\U{ord(one):08x}" for one in quoted)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.0f}" if value == int(value) else repr(value)


def _lines(fields: dict[str, Any], robot: Robot | None = None, table: str = "") -> Iterator[str]:
    """TOML: values first, then tables. For a robot, it has comments, and a line for each body point."""
    tables = {name: value for name, value in fields.items() if isinstance(value, dict)}
    for name, value in fields.items():
        if name in tables:
            continue
        if robot is not None and table == "points":
            links = ["base", *(f"moved by {escape(joint.name, MAX_NAME_CHARS)}" for joint in robot.joints)]
            yield from (f"{name} = [", *(f"  {toml(point)},  # {links[point[0]]}" for point in value), "]")
        else:
            yield from _comments(name, robot, table)
            yield f"{name} = {toml(value)}"
    for name, inside in tables.items():
        path = f"{table}.{name}" if table else name
        yield from ("", *_comments(name, robot, table)) if robot is not None else ()
        yield f"[{path}]"
        yield from _lines(inside, robot, path)


def _comments(name: str, robot: Robot | None, table: str) -> list[str]:
    """What is said before a field or table of the scene."""
    if robot is None or table or name not in COMMENTS:
        return []
    return [*(_joint_lines(robot) if name == "moving_joints" else ()), *f"# {COMMENTS[name]}".split("\n")]


def _joint_lines(robot: Robot) -> Iterator[str]:
    yield "# Joints, base to tip:"
    for number, joint in enumerate(robot.joints, 1):
        if joint.leader is not None:
            motion = f"follows {joint.leader.joint + 1}"
        else:
            motion = "{:.5g}° … {:.5g}°".format(*np.degrees((joint.lower, joint.upper)))
        yield f"#   {number} {escape(joint.name, MAX_NAME_CHARS)}: {motion}"


@cache
def _shipped_fields() -> dict[str, dict[str, Any]]:
    return {name: msgspec.to_builtins(load_scene(name)) for name in scene_names()}


def _only_adds(below: dict[str, Any], above: dict[str, Any]) -> bool:
    """Whether every field below is in `above` too: a scene that extends another one cannot remove fields."""
    return all(
        above.get(name) is not None and (not isinstance(value, dict) or _only_adds(value, above[name]))
        for name, value in below.items()
        if value is not None
    )


def _difference(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Fields of `above` that `below` lacks or has with another value."""
    found = {}
    for name, value in above.items():
        if isinstance(value, dict):
            value = _difference(below.get(name, {}), value)
        if value is not None and value != {} and value != below.get(name):
            found[name] = value
    return found
