"""A scene in few words, which need no file but those that are shipped: what it differs in from one of them."""

from collections.abc import Iterator
from functools import cache

import msgspec

from .derived.scene_file import toml
from .robots import robot_names
from .scene import Scene, load_scene
from .scene_reading import scene_names


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
