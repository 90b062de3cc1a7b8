"""What the arm of a URDF looks like: one mesh for each of its joints and its base, of all that they carry."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import trimesh
from numpy.typing import NDArray

from ..mesh import Mesh
from .rods import rod, stub, foot
from .shape_cache import key_of, kept, keep
from .carried import carried_frames
from .chain import Chain, arm_of
from .mesh_files import load_mesh
from .packages import NotFound, mesh_path
from .reference import Reference
from .simplify import MOST_CARRIED, creased, simplified
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
    """Raises ValueError as `read_tree` and `arm_of`; a mesh that cannot be had is a fault and a rod."""
    tree = read_tree(reference.path)
    return shapes_in(tree, arm_of(tree, reference.base, reference.tip).base, reference)


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
    arm = arm_of(tree, reference.base, reference.tip)
    frames = carried_frames(tree, arm)
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
