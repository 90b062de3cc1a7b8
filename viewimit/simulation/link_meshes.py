"""Shapes of robots' links, as they are drawn."""

from functools import cache

import trimesh

from ..assets import ROOT
from .urdf.reference import is_reference, parse_reference
from .urdf.shapes import shapes_of


def link_meshes(robot: str) -> dict[int, trimesh.Trimesh]:
    """Meshes by link number (0 = base), in the link's frame. robot: as a scene names it. Raises ValueError for a URDF
    that cannot be read."""
    if is_reference(robot):
        return shapes_of(parse_reference(robot)).meshes
    return _shipped(robot)


@cache
def _shipped(robot: str) -> dict[int, trimesh.Trimesh]:
    path = ROOT / "robots" / robot / f"{robot}.glb"
    loaded = trimesh.load_scene(path, process=False).geometry
    return {int(name.removeprefix("link")): one for name, one in loaded.items() if isinstance(one, trimesh.Trimesh)}
