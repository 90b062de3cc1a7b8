"""What the arm of a URDF looks like: one mesh for each of its joints and its base, of all that they carry."""

import contextlib
import hashlib
import importlib.metadata
import os
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np
import platformdirs
import trimesh
from numpy.typing import NDArray

from ...sensing.files import MEGABYTE, read_bytes, read_npz
from ..meshes import Mesh
from .chain import Chain, carrier_frames, find_arm
from .mesh_files import MOST_BYTES, MOST_CARRIED, NotFound, creased, load_mesh, mesh_path, simplified
from .reference import Reference
from .tree import Shape, Tree, read_tree

SIDES = 24  # of a cylinder
MOST_NAMED = 3  # of faults of a kind, each in words


@dataclass(frozen=True, eq=False)
class Shapes:
    """meshes: by link number (0 = base), in the link's frame, m; faults: lines about what is not drawn as it is said
    to be."""

    meshes: dict[int, Mesh]
    faults: tuple[str, ...]


def shapes_of(reference: Reference) -> Shapes:
    """Raises ValueError as `read_tree` and `find_arm`; a mesh that cannot be had is a fault and a rod."""
    tree = read_tree(reference.path)
    return shapes_in(tree, find_arm(tree, reference.base, reference.tip).base, reference)


@lru_cache(8)
def shapes_in(tree: Tree, base: str, reference: Reference) -> Shapes:
    files = dict.fromkeys(shape.file for shapes in tree.shapes.values() for shape in shapes if shape.kind == "mesh")
    if not files:  # others take no time
        meshes, missing = _made(tree, reference)
        return Shapes(meshes, _said(tree, missing))
    key = key_of(tree.path, tree.digest, str(reference), files)
    found = kept(key)
    if found is None:
        found = _made(tree, reference)
        keep(key, *found)
    meshes, missing = found
    return Shapes(meshes, _said(tree, missing))


def _made(tree: Tree, reference: Reference) -> tuple[dict[int, Mesh], list[str]]:
    """Meshes by link number, and what could not be had for them, each once."""
    arm = find_arm(tree, reference.base, reference.tip)
    frames = carrier_frames(tree, arm)
    parts: dict[int, list[trimesh.Trimesh]] = {}
    missing: dict[str, None] = {}
    bare: set[int] = set()  # links of which something is not drawn
    files: dict[str, trimesh.Trimesh] = {}
    for link, shapes in tree.shapes.items():
        carrier, T_carrier_link = frames.get(link, (0, np.eye(4)))
        for shape in shapes:
            try:
                mesh = _mesh(tree, shape, files)
            except NotFound as error:
                missing[str(error)] = None
                bare.add(carrier)
                continue
            if mesh is not None:
                mesh.apply_transform(T_carrier_link @ shape.T_link_shape)
                parts.setdefault(carrier, []).append(mesh)
    undrawn = not any(parts)  # of what moves, for a base is 0
    for number, mesh in _stand_ins(arm, frames):
        if number not in parts and (number in bare or number == 0 or undrawn):
            parts[number] = [mesh]
    whole = {number: creased(simplified(_joined(each), MOST_CARRIED)) for number, each in sorted(parts.items())}
    meshes = {number: Mesh(np.array(mesh.vertices, float), np.array(mesh.faces)) for number, mesh in whole.items()}
    return meshes, list(missing)


def _mesh(tree: Tree, shape: Shape, files: dict[str, trimesh.Trimesh]) -> trimesh.Trimesh | None:
    """In the shape's frame; None if it has no extent. files: those that were read before, small."""
    if shape.kind == "mesh":
        if shape.file not in files:
            files[shape.file] = simplified(load_mesh(mesh_path(tree.path, shape.file)))
        mesh = files[shape.file].copy()
        mesh.apply_scale(shape.size)
        return mesh
    if min(shape.size) <= 0:
        return None
    if shape.kind == "box":
        return trimesh.creation.box(shape.size)
    if shape.kind == "cylinder":
        return trimesh.creation.cylinder(shape.size[0], shape.size[1], sections=SIDES)
    return trimesh.creation.icosphere(2, shape.size[0])


def _stand_ins(arm: Chain, frames: dict[str, tuple[int, NDArray]]) -> Iterator[tuple[int, trimesh.Trimesh]]:
    """By link number, of the base and of each joint of the arm, what stands for its shapes."""
    numbers = [frames[joint.child][0] for joint in arm.joints]
    turned = [(k, joint) for k, joint in enumerate(arm.joints) if not k or numbers[k] != numbers[k - 1]]
    turned = [(k, joint) for k, joint in turned if numbers[k]]
    ends: dict[int, NDArray] = {}
    for joint in arm.joints:
        carrier, T_carrier_parent = frames[joint.parent]
        ends[carrier] = (T_carrier_parent @ joint.T_parent_joint)[:3, 3]
    last = numbers[-1]
    if arm.tip in frames and frames[arm.tip][0] == last:
        ends[last] = frames[arm.tip][1][:3, 3]
    length = max(sum(float(np.linalg.norm(end)) for number, end in ends.items() if number), 1e-3)
    yield 0, foot(ends.get(0, np.zeros(3)), length)
    for k, joint in turned:
        mesh = rod(ends.get(numbers[k], np.zeros(3)), length)
        if mesh is None and numbers[k] == last:
            mesh = stub(joint.axis, length)
        if mesh is not None:
            yield numbers[k], mesh


def _joined(meshes: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts)]
    return trimesh.Trimesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces), process=False)


def _said(tree: Tree, missing: list[str]) -> tuple[str, ...]:
    """Faults, the first few in words."""
    named, more = missing[:MOST_NAMED], len(missing) - MOST_NAMED
    lines = [f"{tree.path}: not drawn: {fault}" for fault in named]
    return (*tree.faults, *lines, *([f"{tree.path}: and {more} more"] if more > 0 else []))


# What stands for links that nobody drew: rods between joints, and a foot under the first.

SLENDER = 0.035  # of an arm's length: the radius of its rods
SHORT = 0.05  # of an arm's length: what is nearer than that has no rod to it
STUB = 0.12  # of an arm's length: a rod that leads nowhere


def rod(end: NDArray, length: float) -> trimesh.Trimesh | None:
    """From the origin to `end` (3,) m, of an arm of that length; None where it would be too short to be seen."""
    distance = float(np.linalg.norm(end))
    if distance < SHORT * length:
        return None
    mesh = trimesh.creation.cylinder(SLENDER * length, distance, sections=12)
    mesh.apply_translation([0, 0, distance / 2])
    mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], end / distance))
    return mesh


def stub(axis: NDArray, length: float) -> trimesh.Trimesh:
    """Of a last link: a bar across its joint's axis, so that it is seen to turn."""
    axis = axis / np.linalg.norm(axis)
    aside = np.cross(axis, [1, 0, 0] if abs(axis[0]) < 0.9 else [0, 1, 0])
    mesh = trimesh.creation.box((STUB * length, SLENDER * length, 2 * SLENDER * length))
    mesh.apply_translation([STUB * length / 2, 0, 0])
    turn = np.eye(4)
    turn[:3, 0] = aside / np.linalg.norm(aside)
    turn[:3, 2] = axis
    turn[:3, 1] = np.cross(turn[:3, 2], turn[:3, 0])
    mesh.apply_transform(turn)
    return mesh


def foot(top: NDArray, length: float) -> trimesh.Trimesh:
    """A block whose top is at (3,) m, where an arm of that length begins."""
    mesh = trimesh.creation.box((0.25 * length, 0.18 * length, 0.12 * length))
    mesh.apply_translation(top - [0, 0, 0.06 * length])
    return mesh


# Shapes of own robots, kept in the user's cache folder: to read and simplify their meshes takes seconds, in every
# process anew.
# They are found by the content of all that they were made from, so that a file that changes makes others. What is
# damaged is made again, what cannot be written is not kept, and the oldest gives way.

FOLDER = "VIEWIMIT_CACHE"  # environment variable: another folder; none is used where it is empty
MOST_KEPT, MOST_KEPT_BYTES = 40, 128 * MEGABYTE
READERS = ("numpy", "trimesh", "pycollada")  # of which another version may read a mesh otherwise

Meshes = dict[int, Mesh]


def key_of(urdf: Path, content: str, chain: str, files: Iterable[str]) -> str:
    """What shapes depend on, as letters. content: digest of the URDF; chain: which of its links are the arm; files:
    meshes, as the URDF names them."""
    key = hashlib.sha256(f"{_made_by()}\0{urdf}\0{content}\0{chain}".encode())
    for name in files:
        try:
            found = hashlib.sha256(read_bytes(mesh_path(urdf, name), MOST_BYTES)).hexdigest()
        except (NotFound, OSError, ValueError) as error:
            found = str(error)
        key.update(f"\0{name}\0{found}".encode())
    return key.hexdigest()


def kept(key: str) -> tuple[Meshes, list[str]] | None:
    """Meshes by link number and what was missing; None where they are not kept."""
    folder = _folder()
    path = None if folder is None else folder / f"{key}.npz"
    if path is None or not path.is_file():
        return None
    try:
        arrays = read_npz(path)
        meshes = {int(link): _checked_mesh(arrays[f"v{link}"], arrays[f"f{link}"]) for link in arrays["links"]}
        missing = [str(line) for line in arrays["unread"]]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # the latest to be used is the last to give way
    return meshes, missing


def keep(key: str, meshes: Meshes, missing: list[str]) -> None:
    """For the next process that asks."""
    folder = _folder()
    if folder is None:
        return
    arrays = {"links": np.array(list(meshes), np.int32), "unread": np.array(missing, str)}
    for link, mesh in meshes.items():
        arrays |= {f"v{link}": mesh.vertices, f"f{link}": mesh.faces.astype(np.int32)}
    with contextlib.suppress(OSError):
        folder.mkdir(0o700, parents=True, exist_ok=True)
        with _written(folder / f"{key}.npz") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]  # whose stub takes no **
        _make_room(folder)


@contextlib.contextmanager
def _written(path: Path) -> Iterator:
    """A file that is there whole, or not at all."""
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
        try:
            yield file
            file.close()
            os.replace(file.name, path)
        except BaseException:
            os.unlink(file.name)
            raise


def _make_room(folder: Path) -> None:
    """The oldest go, beyond what is kept."""
    found = sorted(
        ((path.stat().st_mtime_ns, path.stat().st_size, path) for path in folder.glob("*.npz")), reverse=True
    )
    total = 0
    for k, (_, size, path) in enumerate(found):
        total += size
        if k and (k >= MOST_KEPT or total > MOST_KEPT_BYTES):
            path.unlink(missing_ok=True)


def _checked_mesh(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """Raises ValueError for what is none."""
    flat = vertices.ndim == faces.ndim == 2 and vertices.shape[1] == faces.shape[1] == 3
    if not (flat and len(faces) and np.isfinite(vertices).all() and 0 <= faces.min() <= faces.max() < len(vertices)):
        raise ValueError("no mesh")
    return Mesh(vertices, faces.astype(np.int64))


@cache
def _made_by() -> str:
    """The programs that make shapes of files: their versions, and all that stands here."""
    found = []
    for name in READERS:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found.append(f"{name} {importlib.metadata.version(name)}")
    here = hashlib.sha256(b"\0".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))))
    return f"{found} {here.hexdigest()}"


def _folder() -> Path | None:
    chosen = os.environ.get(FOLDER)
    if chosen is not None:
        return Path(chosen) if chosen else None
    try:
        return platformdirs.user_cache_path("viewimit", appauthor=False) / "shapes"
    except RuntimeError:  # nobody knows a home
        return None
