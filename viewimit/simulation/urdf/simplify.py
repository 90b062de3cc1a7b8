"""Meshes made small enough to be drawn many times, and shaded as their edges are: sharp or round."""

import numpy as np
import trimesh
from numpy.typing import NDArray

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
