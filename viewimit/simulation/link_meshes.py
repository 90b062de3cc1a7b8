"""Shapes of the shipped robots' links, as they are drawn."""

from functools import cache

import trimesh

from ..assets import ROOT


@cache
def link_meshes(robot: str) -> dict[int, trimesh.Trimesh]:
    """Meshes by link number (0 = base), in the link's frame; empty for a robot of the user's own."""
    path = ROOT / "robots" / robot / f"{robot}.glb"
    if not path.is_file():
        return {}
    loaded = trimesh.load_scene(path, process=False).geometry
    return {int(name.removeprefix("link")): one for name, one in loaded.items() if isinstance(one, trimesh.Trimesh)}
