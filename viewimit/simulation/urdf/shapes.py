"""Make one mesh for the base and for each joint of an arm, of all shapes that it moves, and cache the meshes.

Links without shapes are drawn as rods between joints. Reading and simplifying meshes takes seconds, so the result is
kept in the user's cache folder, under a digest of everything it was made from. A file that changes makes a new
entry, a damaged entry is made again, and the oldest entries are removed.
"""

import contextlib
import hashlib
import importlib.metadata
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import platformdirs
import trimesh
from numpy.typing import NDArray

from ...sensing.files import MEGABYTE, read_bytes, read_npz
from ..meshes import Mesh
from .chain import Chain, carrier_frames, find_arm, held_links
from .mesh_files import MAX_BYTES, MAX_LINK_FACES, NotFound, creased, load_mesh, mesh_path, simplified
from .reference import Reference
from .tree import Shape, Tree, read_tree

CYLINDER_SIDES = 24
MAX_SIZE_RATIO = 50  # of meshes and of the distances between joints; those in mm are a thousand times as large
MAX_LISTED = 3  # names of what is not drawn for one reason
ROD_RADIUS = 0.035  # of the arm's length, as the next two
MIN_ROD = 0.05  # nearer joints have no rod between them
STUB = 0.12  # length of a rod that leads nowhere
FOLDER = "VIEWIMIT_CACHE"  # environment variable: another folder, or none if it is empty
MAX_CACHED, MAX_CACHED_BYTES = 40, 128 * MEGABYTE
READERS = ("numpy", "trimesh", "pycollada")  # packages whose version is part of the digest

Floats = NDArray[np.float64]
Meshes = dict[int, Mesh]  # by link number
Made = tuple[Meshes, dict[int, int], list[str]]  # as of `Shapes`


@dataclass(frozen=True, eq=False)
class Shapes:
    """The meshes of an arm."""

    meshes: Meshes  # 0 = base, each in its link's frame [m]
    n_held: Mapping[int, int]  # first faces of each mesh that the arm holds: the others move by themselves
    faults: tuple[str, ...]  # messages about what is not drawn, not understood, or looks wrong

    @property
    def held(self) -> Meshes:
        """What the arm holds of each mesh."""
        return {k: Mesh(mesh.vertices, mesh.faces[: self.n_held[k]]) for k, mesh in self.meshes.items()}

    @property
    def loose(self) -> Meshes:
        """What moves by itself of each mesh."""
        return {k: Mesh(mesh.vertices, mesh.faces[self.n_held[k] :]) for k, mesh in self.meshes.items()}


def shapes_of(reference: Reference) -> Shapes:
    """Return the meshes of an arm. An unreadable mesh becomes a fault and a rod.

    Raises ValueError as `read_tree` and `find_arm`.
    """
    return load_shapes(read_tree(reference.path), reference)


@lru_cache(8)
def load_shapes(tree: Tree, reference: Reference) -> Shapes:
    """Return the meshes of an arm in a URDF that has been read, from the cache if they are there."""
    files = dict.fromkeys(shape.file for shapes in tree.shapes.values() for shape in shapes if shape.kind == "mesh")
    key = _cache_key(tree.digest, reference, files) if files else None  # other shapes take no time
    found = _load_cached(key) if key else None
    if found is None:
        found = _make_meshes(tree, reference)
        if key:
            _store_cached(key, *found)
    meshes, n_held, missing = found
    lines = [f"{tree.path}: not drawn: {fault}" for fault in missing]
    return Shapes(meshes, n_held, (*tree.faults, *lines, *_implausible_size(tree, reference, meshes)))


def _implausible_size(tree: Tree, reference: Reference, meshes: Meshes) -> list[str]:
    """A message about meshes that are far larger or smaller than the distances between the joints."""
    if not any(shape.kind == "mesh" for shapes in tree.shapes.values() for shape in shapes):
        return []
    arm = find_arm(tree, reference.base, reference.tip)
    length = sum(float(np.linalg.norm(joint.T_parent_joint[:3, 3])) for joint in arm.joints)
    extent = max((float(np.ptp(mesh.vertices, axis=0).max()) for mesh in meshes.values()), default=0.0)
    if not length > 0 or 1 / MAX_SIZE_RATIO < extent / length < MAX_SIZE_RATIO:
        return []
    return [
        f"{tree.path}: its meshes are {extent:.3g} m large and its joints {length:.3g} m apart in all: if the meshes "
        'are in mm, add scale="0.001 0.001 0.001" to each <mesh>'
    ]


def _make_meshes(tree: Tree, reference: Reference) -> Made:
    """Meshes by link number, how many of their faces the arm holds, and a message for each reason to draw no more."""
    arm = find_arm(tree, reference.base, reference.tip)
    frames = carrier_frames(tree, arm)
    held = held_links(tree, arm)
    parts: dict[tuple[int, bool], list[trimesh.Trimesh]] = {}  # by carrier, and whether they move by themselves
    missing: dict[str, dict[str, None]] = {}  # names by the reason
    bare: set[int] = set()  # links with a shape that is not drawn
    files: dict[str, trimesh.Trimesh] = {}
    for link, shapes in tree.shapes.items():
        if link not in frames:
            if shapes:
                why = "hangs on nothing that the arm hangs on: add a joint, or take it out"
                missing.setdefault(why, {})[f"link {link!r}"] = None
            continue
        carrier, T_carrier_link = frames[link]
        for shape in shapes:
            try:
                mesh = _shape_mesh(tree, shape, files, reference.meshes)
            except NotFound as error:
                missing.setdefault(error.why, {})[error.name] = None
                bare.add(carrier)
                continue
            if mesh is not None:
                mesh.apply_transform(T_carrier_link @ shape.T_link_shape)
                parts.setdefault((carrier, link not in held), []).append(mesh)
    drawn = {carrier for carrier, loose in parts if not loose}
    undrawn = not any(drawn)  # no moving link has a shape; the base is 0
    for number, mesh in _rods(arm, frames):
        if number not in drawn and (number in bare or undrawn or (number == 0 and (0, True) not in parts)):
            parts[number, False] = [mesh]
    meshes, n_held = {}, {}
    for number in sorted({carrier for carrier, _ in parts}):
        each = [_joined(parts[number, loose]) for loose in (False, True) if (number, loose) in parts]
        whole = cast(trimesh.Trimesh, trimesh.util.concatenate(each))
        meshes[number] = Mesh(np.array(whole.vertices, float), np.array(whole.faces))
        n_held[number] = len(each[0].faces) if (number, False) in parts else 0
    return meshes, n_held, [_listed(names, why) for why, names in missing.items()]


def _joined(parts: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    return creased(simplified(cast(trimesh.Trimesh, trimesh.util.concatenate(parts)), MAX_LINK_FACES))


def _listed(names: Iterable[str], why: str) -> str:
    """What is not drawn for one reason, in a line."""
    first, more = list(names)[:MAX_LISTED], len(list(names)) - MAX_LISTED
    if len(first) == 1:
        return f"{first[0]} {why}"
    return f"{', '.join(first)}{f' and {more} more' if more > 0 else ''}: each {why}"


def _shape_mesh(
    tree: Tree, shape: Shape, files: dict[str, trimesh.Trimesh], folder: Path | None
) -> trimesh.Trimesh | None:
    """Mesh in the shape's frame; None if it has no extent. files: simplified meshes that have been read."""
    if shape.kind == "mesh":
        if shape.file not in files:
            files[shape.file] = simplified(load_mesh(mesh_path(tree.path, shape.file, folder)))
        mesh = files[shape.file].copy()
        mesh.apply_scale(shape.size)
        return mesh
    if min(shape.size) <= 0:
        return None
    if shape.kind == "box":
        return trimesh.creation.box(shape.size)
    if shape.kind == "capsule":
        mesh = trimesh.creation.capsule(height=shape.size[1], radius=shape.size[0], count=[CYLINDER_SIDES, 12])
        mesh.apply_translation(-mesh.bounds.mean(0))
        return mesh
    if shape.kind == "cylinder":
        return trimesh.creation.cylinder(shape.size[0], shape.size[1], sections=CYLINDER_SIDES)
    return trimesh.creation.icosphere(2, shape.size[0])


def _rods(arm: Chain, frames: dict[str, tuple[int, Floats]]) -> Iterator[tuple[int, trimesh.Trimesh]]:
    """Rods for the base and each joint of the arm, by link number."""
    numbers = [frames[joint.child][0] for joint in arm.joints]
    turned = [(k, joint) for k, joint in enumerate(arm.joints) if not k or numbers[k] != numbers[k - 1]]
    turned = [(k, joint) for k, joint in turned if numbers[k]]
    ends: dict[int, Floats] = {}
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


def rod(end: Floats, length: float) -> trimesh.Trimesh | None:
    """Return a rod from the origin to `end`, (3,) m, for an arm of that length; None if it is too short to see."""
    distance = float(np.linalg.norm(end))
    if distance < MIN_ROD * length:
        return None
    mesh = trimesh.creation.cylinder(ROD_RADIUS * length, distance, sections=12)
    mesh.apply_translation([0, 0, distance / 2])
    mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], end / distance))
    return mesh


def stub(axis: Floats, length: float) -> trimesh.Trimesh:
    """Return a bar across the axis of the last joint, so that its rotation is visible."""
    axis = axis / np.linalg.norm(axis)
    across = np.cross(axis, [1, 0, 0] if abs(axis[0]) < 0.9 else [0, 1, 0])
    mesh = trimesh.creation.box((STUB * length, ROD_RADIUS * length, 2 * ROD_RADIUS * length))
    mesh.apply_translation([STUB * length / 2, 0, 0])
    turn = np.eye(4)
    turn[:3, 0] = across / np.linalg.norm(across)
    turn[:3, 2] = axis
    turn[:3, 1] = np.cross(turn[:3, 2], turn[:3, 0])
    mesh.apply_transform(turn)
    return mesh


def foot(top: Floats, length: float) -> trimesh.Trimesh:
    """Return a block with its top at (3,) m, where an arm of that length starts."""
    mesh = trimesh.creation.box((0.25 * length, 0.18 * length, 0.12 * length))
    mesh.apply_translation(top - [0, 0, 0.06 * length])
    return mesh


def _cache_key(content: str, reference: Reference, files: Iterable[str]) -> str:
    """Digest of everything that the meshes depend on.

    content: digest of the URDF; files: meshes, as the URDF names them.
    """
    key = hashlib.sha256(f"{_versions()}\0{content}\0{reference}".encode())
    for name in files:
        try:
            found = hashlib.sha256(read_bytes(mesh_path(reference.path, name, reference.meshes), MAX_BYTES)).hexdigest()
        except (NotFound, OSError, ValueError) as error:
            found = str(error)
        key.update(f"\0{name}\0{found}".encode())
    return key.hexdigest()


def _load_cached(key: str) -> Made | None:
    """As `_make_meshes`; None if they are not cached."""
    folder = _cache_folder()
    path = None if folder is None else folder / f"{key}.npz"
    if path is None or not path.is_file():
        return None
    try:
        arrays = read_npz(path)
        meshes = {int(link): _checked_mesh(arrays[f"v{link}"], arrays[f"f{link}"]) for link in arrays["links"]}
        n_held = dict(zip(meshes, arrays["held"].tolist(), strict=True))
        missing = [str(line) for line in arrays["unread"]]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # the least recently used are removed first
    return meshes, n_held, missing


def _store_cached(key: str, meshes: Meshes, n_held: dict[int, int], missing: list[str]) -> None:
    folder = _cache_folder()
    if folder is None:
        return
    arrays = {"links": np.array(list(meshes), np.int32), "unread": np.array(missing, str)}
    arrays["held"] = np.array([n_held[link] for link in meshes], np.int32)
    for link, mesh in meshes.items():
        arrays |= {f"v{link}": mesh.vertices, f"f{link}": mesh.faces.astype(np.int32)}
    with contextlib.suppress(OSError):
        folder.mkdir(0o700, parents=True, exist_ok=True)
        with _atomic_write(folder / f"{key}.npz") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]  # the stub takes no **
        _remove_oldest(folder)


@contextlib.contextmanager
def _atomic_write(path: Path) -> Iterator[Any]:
    """Open a file that appears only once it is complete."""
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
        try:
            yield file
            file.close()
            os.replace(file.name, path)
        except BaseException:
            file.close()  # Windows removes no open file
            os.unlink(file.name)
            raise


def _remove_oldest(folder: Path) -> None:
    found = sorted(
        ((path.stat().st_mtime_ns, path.stat().st_size, path) for path in folder.glob("*.npz")), reverse=True
    )
    total = 0
    for k, (_, size, path) in enumerate(found):
        total += size
        if k and (k >= MAX_CACHED or total > MAX_CACHED_BYTES):
            path.unlink(missing_ok=True)


def _checked_mesh(vertices: NDArray[Any], faces: NDArray[Any]) -> Mesh:
    """Return a mesh. Raises ValueError for damaged arrays."""
    flat = vertices.ndim == faces.ndim == 2 and vertices.shape[1] == faces.shape[1] == 3
    if not (flat and len(faces) and np.isfinite(vertices).all() and 0 <= faces.min() <= faces.max() < len(vertices)):
        raise ValueError("no mesh")
    return Mesh(vertices, faces.astype(np.int64))


@cache
def _versions() -> str:
    """Versions of the packages that read meshes, and a digest of this package's source."""
    found = []
    for name in READERS:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found.append(f"{name} {importlib.metadata.version(name)}")
    here = hashlib.sha256(b"\0".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))))
    return f"{found} {here.hexdigest()}"


def _cache_folder() -> Path | None:
    chosen = os.environ.get(FOLDER)
    if chosen is not None:
        return Path(chosen) if chosen else None
    try:
        return platformdirs.user_cache_path("viewimit", appauthor=False) / "shapes"
    except RuntimeError:  # no home folder
        return None
