"""Meshes from files, by trimesh: triangles alone, no materials, no pictures, and no other file that a file names."""

import io
import os
import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import trimesh
from numpy.typing import NDArray

from ...sensing.files import read_bytes

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


# Where the meshes are that a URDF names, and that nothing else is read.
# Relative paths are those from its folder. `package://name/…` is sought in the folders above it, and
# along ROS_PACKAGE_PATH. What lies elsewhere, and what has an address on a network,
# is refused.

USUAL_FOLDERS = ("urdf", "urdfs", "robots", "robot", "model", "models", "xacro", "description")  # of files in a package
PACKAGE_FILE = "package.xml"


class NotFound(Exception):
    """The message says what is not there, or not read."""


def mesh_path(urdf: Path, name: str) -> Path:
    """The file that a mesh's name in the URDF means. Raises NotFound."""
    if not name:
        raise NotFound("a mesh without a filename")
    scheme, _, rest = name.partition("://") if "://" in name else ("", "", name)
    if scheme == "package":
        return _in_package(urdf, *unquote(rest).partition("/")[::2])
    if scheme not in ("", "file"):
        raise NotFound(f"{name} is not fetched: put the file beside the URDF")
    path = Path(unquote(rest) if scheme else rest.replace("\\", "/"))
    found = (urdf.parent / path).resolve()
    allowed = [own_tree(urdf), *_ros_folders()]
    if not any(found.is_relative_to(folder) for folder in allowed):
        raise NotFound(f"{name} lies outside {allowed[0]} and is not read: move it there")
    return _file(found, name)


def own_tree(urdf: Path) -> Path:
    """The package that a URDF is of, if it says so or looks so, else the URDF's folder."""
    folder = urdf.resolve().parent
    for above in (folder, *folder.parents[:3]):
        if (above / PACKAGE_FILE).is_file() and above != Path(above.anchor):
            return above
    return folder.parent if folder.name.lower() in USUAL_FOLDERS and len(folder.parts) > 2 else folder


def _in_package(urdf: Path, package: str, rest: str) -> Path:
    if not re.fullmatch(r"[\w.+-]+", package) or package in (".", ".."):
        raise NotFound(f"package://{package}/{rest} names no package")
    first = None
    for folder in _package_folders(urdf, package):
        first = first or folder
        path = (folder / rest).resolve()
        if not path.is_relative_to(folder.resolve()):
            raise NotFound(f"package://{package}/{rest} leads out of {folder} and is not read")
        if path.is_file():
            return path
    if first is None:
        raise NotFound(f"no folder {package} above {urdf.parent or '.'} nor in ROS_PACKAGE_PATH")
    return _file(first / rest, str(first / rest))


def _package_folders(urdf: Path, package: str) -> list[Path]:
    above = [folder for folder in urdf.resolve().parents if len(folder.parts) > 1]
    named = [place for folder in above for place in (folder, folder / package)]
    named += [place for folder in _ros_folders() for place in (folder, folder / package)]
    return [folder for folder in named if folder.name == package and folder.is_dir()]


def _ros_folders() -> list[Path]:
    return [Path(folder).resolve() for folder in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if folder]


def _file(path: Path, name: str) -> Path:
    if not path.is_file():
        raise NotFound(f"{name} is not there")
    return path


# Meshes made small enough to be drawn many times, and shaded as their edges are: sharp or round.

MOST_FACES, MOST_CARRIED = 1500, 6000  # of a file, of all that one joint carries
FINEST, COARSEST = 128, 4  # cells along the longest side
CREASE = np.cos(np.radians(38.0))  # edges sharper than that are shaded as edges


def simplified(mesh: trimesh.Trimesh, most_faces: int = MOST_FACES) -> trimesh.Trimesh:
    """Vertices in one cell of a grid become one, in their middle; the grid is the finest that leaves so few faces
    (Rossignac and Borrel 1993)."""
    if len(mesh.faces) <= most_faces:
        return mesh
    best = vertices, faces = _clustered(mesh.vertices, mesh.faces, FINEST)
    low, high = COARSEST, FINEST if len(faces) > most_faces else COARSEST - 1
    while low <= high:
        cells = (low + high) // 2
        found = _clustered(vertices, faces, cells)
        if len(found[1]) <= most_faces or cells == COARSEST:
            best, low = found, cells + 1
        else:
            high = cells - 1
    return trimesh.Trimesh(*best, process=False)


def creased(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Faces share a vertex only if a fan of flat edges about it joins them, so that normals may be averaged at every
    vertex."""
    merged = mesh.copy()
    merged.merge_vertices()
    merged.update_faces(merged.nondegenerate_faces())
    if not len(merged.faces):
        return mesh
    faces, normals = merged.faces, merged.face_normals
    pairs = merged.face_adjacency
    flat = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(1) > CREASE
    pairs, ends = pairs[flat], merged.face_adjacency_edges[flat]
    corner = lambda face, vertex: 3 * face + np.argmax(faces[face] == vertex[:, None], axis=1)
    one = np.concatenate([corner(pairs[:, 0], ends[:, k]) for k in (0, 1)])
    other = np.concatenate([corner(pairs[:, 1], ends[:, k]) for k in (0, 1)])
    group = _joined(faces.size, one, other)
    _, first, index = np.unique(group, return_index=True, return_inverse=True)
    return trimesh.Trimesh(merged.vertices[faces.ravel()[first]], index.reshape(-1, 3), process=False)


def _joined(count: int, one: NDArray, other: NDArray) -> NDArray:
    """The least of all those that pairs join each with, (count,)."""
    group = np.arange(count)
    while True:
        before = group.copy()
        least = np.minimum(group[one], group[other])
        np.minimum.at(group, one, least)
        np.minimum.at(group, other, least)
        group = group[group]
        if (group == before).all():
            return group


def _clustered(vertices: NDArray, faces: NDArray, cells: int) -> tuple[NDArray, NDArray]:
    low, high = vertices.min(0), vertices.max(0)
    edge = max(float((high - low).max()), 1e-9) / cells
    cell = ((vertices - low) / edge).astype(np.int64)
    number = (cell[:, 0] * (cells + 1) + cell[:, 1]) * (cells + 1) + cell[:, 2]
    _, index, count = np.unique(number, return_inverse=True, return_counts=True)
    index = index.reshape(-1)
    middle = np.stack([np.bincount(index, vertices[:, k]) for k in range(3)], -1) / count[:, None]
    faces = index[faces]
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    low_to_high = np.sort(faces, axis=1)
    _, kept = np.unique((low_to_high[:, 0] * len(count) + low_to_high[:, 1]) * len(count) + low_to_high[:, 2], True)
    return middle, faces[np.sort(kept)]
