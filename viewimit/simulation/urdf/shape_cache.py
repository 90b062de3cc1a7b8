"""Shapes of own robots, kept in the user's cache folder: to read and simplify their meshes takes seconds, in every
process anew.

They are found by the content of all that they were made from, so that a file that changes makes others. What is
damaged is made again, what cannot be written is not kept, and the oldest gives way.
"""

import contextlib
import hashlib
import importlib.metadata
import os
import tempfile
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import platformdirs

from ...sensing.files import MEGABYTE, read_bytes, read_npz
from ..mesh import Mesh
from .mesh_files import MOST_BYTES
from .packages import NotFound, mesh_path

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
