"""Find, read, simplify and shade the mesh files of a URDF.

Relative paths start at the URDF's folder. `package://name/…` and `model://name/…` are looked for in the folders above
it, in those of that name, and along ROS_PACKAGE_PATH and AMENT_PREFIX_PATH. What is not there is looked for in a
further folder, if the user names one (--meshes). Files elsewhere and addresses on a network are refused. trimesh reads
triangles only: no materials, no pictures, and no other file that a mesh names.
"""

import contextlib
import io
import logging
import os
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import trimesh
from numpy.typing import NDArray

from ...geometry.arrays import Floats
from ...geometry.components import connected_components
from ...sensing.files import read_bytes

FORMATS = ("stl", "obj", "dae", "glb", "ply", "off")
MAX_BYTES = 50_000_000
MAX_LENGTH = 1e6  # in the unit of the file
STL_HEAD, STL_TRIANGLE = 84, 50  # bytes of a binary STL; the last four of its head are the number of triangles
MAX_SNIFFED = 1000  # bytes of an ASCII STL, among which the first facet is
PACKAGE_SUBFOLDERS = ("urdf", "urdfs", "robots", "robot", "model", "models", "xacro", "description")  # of URDFs
PACKAGE_FILE = "package.xml"
MAX_FILE_FACES, MAX_LINK_FACES = 1500, 6000  # of one file, and of all shapes that one joint moves
MAX_CELLS, MIN_CELLS = 128, 4  # along the longest side
CREASE_COS = np.cos(np.radians(38.0))  # sharper edges are shaded as edges


class NotFound(Exception):
    """A mesh, by the name that the URDF or its file has, is missing or not read."""

    def __init__(self, name: str, why: str):
        super().__init__(f"{name} {why}")
        self.name, self.why = name, why


def load_mesh(path: Path) -> trimesh.Trimesh:
    """Read a mesh [m]. Raises NotFound if it cannot be read."""
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise NotFound(path.name, f"is not read: convert it to one of {', '.join(FORMATS)}")
    try:
        content = read_bytes(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        raise NotFound(path.name, f"is not read: {error}: simplify it, or leave it out") from None
    if kind == "dae" and (b"<!DOCTYPE" in content or b"<!ENTITY" in content):
        raise NotFound(path.name, "defines entities, and is not read: take them out")
    if kind == "stl":
        content = _whole_stl(path, content)
    if kind == "dae" and content.startswith(b"PK"):
        raise NotFound(path.name, "is an archive, and is not read: unpack it")
    try:
        with _quiet():  # of materials, which are not read
            loaded = trimesh.load(io.BytesIO(content), file_type=kind, process=False, skip_materials=True)
        mesh = loaded.to_mesh() if isinstance(loaded, trimesh.Scene) else loaded
    except Exception as error:  # readers of broken files raise anything
        raise NotFound(path.name, f"does not load: {error or type(error).__name__}".splitlines()[0]) from None
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces) or not np.isfinite(mesh.vertices).all():
        raise NotFound(path.name, "has no triangles")
    if np.abs(mesh.vertices).max() > MAX_LENGTH:
        raise NotFound(path.name, f"has vertices beyond {MAX_LENGTH:g}")
    if not mesh.area > 0:  # invisible, and without room for body points
        raise NotFound(path.name, "has triangles without an area alone")
    return trimesh.Trimesh(mesh.vertices * _unit_m(content, kind), mesh.faces, process=False)


def _whole_stl(path: Path, content: bytes) -> bytes:
    """A binary STL without what many exporters write after its last triangle. Raises NotFound for one that is cut."""
    if len(content) < STL_HEAD or content.lstrip()[:5] == b"solid" and b"facet" in content[:MAX_SNIFFED]:
        return content
    count = int.from_bytes(content[STL_HEAD - 4 : STL_HEAD], "little")
    end = STL_HEAD + STL_TRIANGLE * count
    if end > len(content):
        there = (len(content) - STL_HEAD) // STL_TRIANGLE
        raise NotFound(path.name, f"is cut off: it has {there} of {count} triangles")
    return content[:end]


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Let trimesh log nothing inside: its warnings are of what is not read here."""
    logger = logging.getLogger("trimesh")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(level)


def _unit_m(content: bytes, kind: str) -> float:
    """Unit of a COLLADA file [m]. Its upward axis is ignored, as ROS does."""
    found = re.search(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)", content[:100_000]) if kind == "dae" else None
    try:
        unit = float(found[1]) if found else 1.0
    except ValueError:
        return 1.0
    return unit if np.isfinite(unit) and unit > 0 else 1.0


def mesh_path(urdf: Path, name: str, folder: Path | None = None) -> Path:
    """Return the file of a mesh as the URDF names it, in its usual place or in a further folder. Raises NotFound."""
    if not name:
        raise NotFound("a mesh", "has no filename")
    try:
        return _usual_path(urdf, name)
    except NotFound as error:
        if folder is None:
            raise NotFound(error.name, f"{error.why}: name the folder where it is by --meshes DIR") from None
        found = _in_folder(urdf, name, folder.resolve())
        if found is None:
            raise NotFound(error.name, f"{error.why}, nor is it in {folder}") from None
        return found


def _in_folder(urdf: Path, name: str, folder: Path) -> Path | None:
    """The file as the URDF names it, if it is inside a folder, or the one there whose path ends like that."""
    parts = [part for part in unquote(name).replace("\\", "/").split("/") if part not in ("", ".", "..")]
    tails = [folder.joinpath(*parts[k:]) for k in range(len(parts))]
    for path in (urdf.parent / unquote(name.replace("\\", "/")), *tails):
        found = path.resolve()
        if found.is_relative_to(folder) and found.is_file():
            return found
    return None


def _usual_path(urdf: Path, name: str) -> Path:
    scheme, _, rest = name.partition("://") if "://" in name else ("", "", name)
    if name.startswith("file:"):  # file:/a, file:///a, file://localhost/a
        scheme, rest = "file", re.sub(r"^file:(//(localhost)?(?=/)|//)?", "", name)
    if scheme in ("package", "model"):
        return _in_package(urdf, *unquote(rest).partition("/")[::2])
    if scheme not in ("", "file"):
        raise NotFound(name, "is not fetched: put the file beside the URDF")
    path = Path(unquote(rest) if scheme else rest.replace("\\", "/"))
    found = (urdf.parent / path).resolve()
    if not found.is_file() and "%" in rest:
        found = (urdf.parent / unquote(rest)).resolve()
    allowed = [package_root(urdf), *_ros_folders()]
    if not any(found.is_relative_to(folder) for folder in allowed):
        raise NotFound(name, f"lies outside {allowed[0]} and is not read")
    return _require_file(found, name)


def package_root(urdf: Path) -> Path:
    """Return the folder of the URDF's package if there seems to be one, otherwise the URDF's folder."""
    folder = urdf.resolve().parent
    for above in (folder, *folder.parents[:3]):
        if (above / PACKAGE_FILE).is_file() and above != Path(above.anchor):
            return above
    return folder.parent if folder.name.lower() in PACKAGE_SUBFOLDERS and len(folder.parts) > 2 else folder


def _in_package(urdf: Path, package: str, rest: str) -> Path:
    name, folders = f"package://{package}/{rest}", _package_folders(urdf, package)
    if not re.fullmatch(r"[\w.+-]+", package) or package in (".", ".."):
        raise NotFound(name, "names no package")
    for folder in folders:
        path = (folder / rest).resolve()
        if not path.is_relative_to(folder.resolve()):
            raise NotFound(name, f"leads out of {folder} and is not read")
        if path.is_file():
            return path
    if not folders:
        where = f"above {urdf.parent or '.'} nor in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"
        raise NotFound(name, f"has no folder {package} {where}")
    return _require_file(folders[0] / rest, str(folders[0] / rest))


def _package_folders(urdf: Path, package: str) -> list[Path]:
    above = [folder for folder in urdf.resolve().parents if len(folder.parts) > 1]
    named = [place for folder in (*above, *_ros_folders()) for place in (folder, folder / package)]
    return [folder for folder in named if folder.name == package and folder.is_dir()]


def _ros_folders() -> list[Path]:
    """Where ROS 1 and ROS 2 look for packages."""
    folders = [Path(folder) for folder in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if folder]
    prefixes = [Path(prefix) for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
    return [folder.resolve() for folder in (*folders, *(prefix / "share" for prefix in prefixes))]


def _require_file(path: Path, name: str) -> Path:
    if not path.is_file():
        raise NotFound(name, "is not there")
    return path


def simplified(mesh: trimesh.Trimesh, max_faces: int = MAX_FILE_FACES) -> trimesh.Trimesh:
    """Merge the vertices in each cell of a grid, the finest one that leaves at most this number of faces.

    See Rossignac and Borrel, Multi-resolution 3D approximations for rendering complex scenes, 1993.
    """
    if len(mesh.faces) <= max_faces:
        return mesh
    best = vertices, faces = _clustered(mesh.vertices, mesh.faces, MAX_CELLS)
    low, high = MIN_CELLS, MAX_CELLS if len(faces) > max_faces else MIN_CELLS - 1
    while low <= high:
        cells = (low + high) // 2
        found = _clustered(vertices, faces, cells)
        if len(found[1]) <= max_faces or cells == MIN_CELLS:
            best, low = found, cells + 1
        else:
            high = cells - 1
    return trimesh.Trimesh(*best, process=False)


def creased(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Split vertices at creases, so that normals may be averaged at every vertex.

    Afterwards, faces share a vertex only if a fan of flat edges joins them.
    """
    merged = mesh.copy()
    merged.merge_vertices()
    merged.update_faces(merged.nondegenerate_faces())
    if not len(merged.faces):
        return mesh
    faces, normals = merged.faces, merged.face_normals
    pairs = merged.face_adjacency
    flat = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(1) > CREASE_COS
    pairs, ends = pairs[flat], merged.face_adjacency_edges[flat]
    corner = lambda face, vertex: 3 * face + np.argmax(faces[face] == vertex[:, None], axis=1)
    one = np.concatenate([corner(pairs[:, 0], ends[:, k]) for k in (0, 1)])
    other = np.concatenate([corner(pairs[:, 1], ends[:, k]) for k in (0, 1)])
    group = connected_components(faces.size, one, other)
    _, first, index = np.unique(group, return_index=True, return_inverse=True)
    return trimesh.Trimesh(merged.vertices[faces.ravel()[first]], index.reshape(-1, 3), process=False)


def _clustered(vertices: Floats, faces: NDArray[np.int_], cells: int) -> tuple[Floats, NDArray[np.int_]]:
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
