"""Meshes from files, by trimesh: triangles alone, no materials, no pictures, and no other file that a file names."""

import io
import re
from pathlib import Path

import numpy as np
import trimesh

from ...sensing.files import read_bytes
from .packages import NotFound

FORMATS = ("stl", "obj", "dae", "glb", "ply", "off")
MOST_BYTES = 50_000_000
MOST_LENGTH = 1e6  # in the units of the file


def load_mesh(path: Path) -> trimesh.Trimesh:
    """In metres. Raises NotFound for what is no mesh that can be read."""
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise NotFound(f"{path.name} is not read: convert it to one of {', '.join(FORMATS)}")
    try:
        content = read_bytes(path, MOST_BYTES)
    except (OSError, ValueError) as error:
        raise NotFound(f"{error}: simplify it, or leave it out") from None
    if kind == "dae" and (b"<!DOCTYPE" in content or b"<!ENTITY" in content):
        raise NotFound(f"{path.name} defines entities, and is not read: take them out")
    if kind == "dae" and content.startswith(b"PK"):
        raise NotFound(f"{path.name} is an archive, and is not read: unpack it")
    try:
        loaded = trimesh.load(io.BytesIO(content), file_type=kind, process=False, skip_materials=True)
        mesh = loaded.to_mesh() if isinstance(loaded, trimesh.Scene) else loaded
    except Exception as error:  # whatever a reader of broken files raises
        raise NotFound(f"{path.name} does not load: {error or type(error).__name__}".splitlines()[0]) from None
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces) or not np.isfinite(mesh.vertices).all():
        raise NotFound(f"{path.name} has no triangles")
    if np.abs(mesh.vertices).max() > MOST_LENGTH:
        raise NotFound(f"{path.name} has vertices beyond {MOST_LENGTH:g}")
    if not mesh.area > 0:  # nothing is seen of it, and no body point can be on it
        raise NotFound(f"{path.name} has triangles without an area alone")
    return trimesh.Trimesh(mesh.vertices * _metres(content, kind), mesh.faces, process=False)


def _metres(content: bytes, kind: str) -> float:
    """A unit of the file's own: COLLADA says so. Its upward axis is not heeded, as ROS does not."""
    found = re.search(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)", content[:100_000]) if kind == "dae" else None
    try:
        unit = float(found[1]) if found else 1.0
    except ValueError:
        return 1.0
    return unit if np.isfinite(unit) and unit > 0 else 1.0
