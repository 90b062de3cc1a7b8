"""Small URDFs, written for a test: joints and links in a line each."""

import re
from pathlib import Path

LIMIT = '<limit lower="-2" upper="2"/>'
BOX = '<visual><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></visual>'


def link(name: str, size: str = "", at: str = "0 0 0", visual: str = "") -> str:
    """size: of a box that is seen of it, if anything; visual: instead, as it stands in the file."""
    return f'<link name="{name}">{BOX.format(at=at, size=size) if size else visual}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    axis: str = "0 1 0",
    xyz: str = "0 0 0",
    more: str = LIMIT,
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def robot(*parts: str) -> str:
    """With the links that joints name and parts do not have, unless they have none at all."""
    inside = "".join(parts)
    there = re.findall(r'<link name="([^"]*)"', inside)
    named = dict.fromkeys(re.findall(r'<(?:parent|child) link="([^"]*)"', inside)) if there else ()
    return f'<robot name="small">{inside}{"".join(link(name) for name in named if name not in there)}</robot>'


def write(folder: Path, *parts: str, name: str = "small.urdf") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(robot(*parts), encoding="utf-8")
    return path


def arm(*more: str) -> tuple[str, ...]:
    """Three joints and their visible links, and any others below them."""
    return (
        link("base", "0.2 0.2 0.1"),
        joint("yaw", "base", "shoulder", axis="0 0 1", xyz="0 0 0.1"),
        link("shoulder", "0.1 0.14 0.1"),
        joint("lift", "shoulder", "upper", xyz="0 0 0.1"),
        link("upper", "0.08 0.06 0.4", at="0 0 0.2"),
        joint("elbow", "upper", "lower", xyz="0 0 0.4"),
        link("lower", "0.06 0.08 0.3", at="0.03 0 0.15"),
        *more,
    )


def gripper(parent: str) -> tuple[str, ...]:
    """Two fingers, one of which mimics the other."""
    short, mimic = (
        '<limit lower="0" upper="0.8"/>',
        '<limit lower="0" upper="0.8"/><mimic joint="left" multiplier="-1"/>',
    )
    return (
        joint("hold", parent, "palm", "fixed", xyz="0 0 0.3"),
        link("palm", "0.05 0.1 0.02"),
        joint("left", "palm", "one", xyz="0 0.03 0", more=short),
        link("one", "0.01 0.01 0.05", at="0 0 0.025"),
        joint("right", "palm", "other", xyz="0 -0.03 0", more=mimic),
        link("other", "0.01 0.01 0.05", at="0 0 0.025"),
    )
