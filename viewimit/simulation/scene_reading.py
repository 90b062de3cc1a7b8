"""What a scene file says, with all that it takes over from the scenes it extends."""

from functools import lru_cache
from pathlib import Path

import numpy as np

from ..assets import ROOT
from ..sensing.files import parse_toml, read_toml
from .robots import robot_names

MOST_EXTENDED = 16  # scenes that one builds on
MOST_TEXT = 20_000  # characters of a scene that is told in full
MOST_NUMBER = 1e6  # of anything in a scene: m, px or degrees


def scene_names() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in (ROOT / "scenes").glob("*.toml"))


def read_fields(path: Path, above: tuple[Path, ...] = ()) -> dict:
    """Before their types are checked. above: scenes that build on this one."""
    fields = dict(_decoded(read_toml(path)))
    if "extends" not in fields:
        return fields
    above = (*above, path.resolve())
    parent = fields.pop("extends")
    beside, shipped = (folder / f"{parent}.toml" for folder in (path.parent, ROOT / "scenes"))
    if not (beside.is_file() or shipped.is_file()):
        raise ValueError(f"extends {parent!r}, but there is no {beside}, nor a shipped scene of that name")
    below = beside if beside.is_file() else shipped
    if below.resolve() in above:
        raise ValueError(f"extends {parent!r}, which builds on it: a scene cannot build on itself")
    if len(above) > MOST_EXTENDED:
        raise ValueError(f"extends {parent!r}: more than {MOST_EXTENDED} scenes build on each other")
    return merged(read_fields(below, above), fields)


def read_text(text: str) -> dict:
    """Wherever it comes from, it opens no file but those that are shipped."""
    if len(text) > MOST_TEXT:
        raise ValueError(f"it has {len(text)} characters, more than {MOST_TEXT}")
    fields = dict(_decoded(text.encode()))
    parent = fields.pop("extends", None)
    if parent is not None:
        if parent not in scene_names():
            raise ValueError(f"extends {str(parent)[:40]!r}, which is no shipped scene")
        fields = merged(read_fields(ROOT / "scenes" / f"{parent}.toml"), fields)
    if fields.get("robot") not in robot_names():
        raise ValueError(f"its robot, {str(fields.get('robot'))[:40]!r}, is none of {', '.join(robot_names())}")
    return fields


@lru_cache(16)  # every run of a study begins with it
def _decoded(content: bytes) -> dict:
    fields = parse_toml(content)
    try:
        _require_finite(fields)
    except RecursionError:
        raise ValueError("it nests too deeply") from None
    return fields


def merged(below: dict, above: dict) -> dict:
    """above: wins, table by table."""
    fields = dict(below)
    for key, value in above.items():
        both = isinstance(value, dict) and isinstance(below.get(key), dict)
        fields[key] = merged(below[key], value) if both else value
    return fields


def _require_finite(value, name: str = "") -> None:
    """TOML can say nan, inf, and more than anybody can compute with."""
    if isinstance(value, (int, float)) and not abs(value) <= MOST_NUMBER:
        finite = isinstance(value, int) or np.isfinite(value)
        wanted = f"within ±{MOST_NUMBER:g}" if finite else "a finite number"
        raise ValueError(f"{name} is {str(value)[:20]}, not {wanted}")
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        _require_finite(item, f"{name}.{key}".lstrip("."))
