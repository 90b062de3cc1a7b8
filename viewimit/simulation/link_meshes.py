"""Shapes of robots' links, as they are drawn."""

from functools import cache

from ..assets import ROOT
from .mesh import Mesh, read_glb
from .urdf.reference import is_reference, parse_reference


def link_meshes(robot: str) -> dict[int, Mesh]:
    """Meshes by link number (0 = base), in the link's frame. robot: as a scene names it. Raises ValueError for a URDF
    that cannot be read."""
    if is_reference(robot):
        from .urdf.shapes import shapes_of  # loads trimesh

        return shapes_of(parse_reference(robot)).meshes
    return _shipped(robot)


@cache
def _shipped(robot: str) -> dict[int, Mesh]:
    meshes = read_glb(ROOT / "robots" / robot / f"{robot}.glb")
    return {int(name.removeprefix("link")): mesh for name, mesh in meshes.items()}
