"""Name a robot by its URDF, by a robot of the package `robot_descriptions`, and refuse other formats.

A reference is the path of a URDF, `arm.urdf`, or names the chain that is the arm too, and a further folder of meshes:
`arm.urdf#base=torso&tip=left_hand&meshes=../parts`. Characters of a name that would end it are quoted as in a URL: %26
for &.
"""

import importlib.util
import os
import re
import runpy
import shlex
import sys
import types
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from ...sensing.files import MEGABYTE, require_file

PARTS = ("base", "tip", "meshes")
ENDING = r"\.urdf(?:#(.*))?$"  # of a path, which may contain #
QUOTED = str.maketrans({letter: f"%{ord(letter):02X}" for letter in "%&#"})
PACKAGE = "robot_descriptions"
CACHE = "~/.cache/robot_descriptions"
MAX_BYTES = 32 * MEGABYTE
MAX_SNIFFED_BYTES = 4000  # of a file whose name does not tell its format
COMMANDS = {  # that convert another format
    "xacro": "pip install xacrodoc && xacrodoc {quoted} -o {quoted_out}",
    "MJCF": "pip install mjcf-urdf-simple-converter && "
    "python -c \"from mjcf_urdf_simple_converter import convert; convert('{file}', '{out}')\"",
    "SDF": 'python -c "import pybullet as p; from pybullet_utils.urdfEditor import UrdfEditor as E; '
    "p.connect(p.DIRECT); e = E(); e.initializeFromBulletBody(p.loadSDF('{file}')[0], 0); e.saveUrdf('{out}')\"",
}
SUFFIXES = {".xacro": "xacro", ".mjcf": "MJCF", ".sdf": "SDF"}
ROOTS = {"mujoco": "MJCF", "sdf": "SDF", "robot": "URDF"}  # root elements of .xml files
XACRO = "xacro}"  # end of the namespace of xacro's elements


@dataclass(frozen=True)
class Reference:
    """A URDF, the links between which the arm is, or None to let `find_arm` choose, and a further folder of meshes."""

    path: Path
    base: str | None = None
    tip: str | None = None
    meshes: Path | None = None

    def __str__(self) -> str:
        parts = {part: getattr(self, part) for part in PARTS}
        named = [f"{part}={str(name).translate(QUOTED)}" for part, name in parts.items() if name is not None]
        return f"{self.path}#{'&'.join(named)}" if named else str(self.path)


def is_reference(name: object) -> bool:
    """Return whether a robot is named by a URDF."""
    return re.search(ENDING, str(name), re.IGNORECASE) is not None


def parse_reference(name: str | Path) -> Reference:
    """Parse a reference. Raises ValueError if another word than base, tip or meshes follows #."""
    found = re.search(ENDING, str(name), re.IGNORECASE)
    fragment = found[1] if found and found[1] else ""
    path = str(name).removesuffix(f"#{fragment}")
    parts = {part.partition("=")[0]: unquote(part.partition("=")[2]) for part in fragment.split("&") if part}
    if wrong := [part for part, link in parts.items() if part not in PARTS or not link]:
        raise ValueError(
            f"{path}: #{wrong[0]} is not read: say {path}#base=LINK&tip=LINK&meshes=FOLDER, or some of them"
        )
    meshes = Path(parts["meshes"]) if "meshes" in parts else None
    return Reference(Path(path), parts.get("base"), parts.get("tip"), meshes)


class _NotCloned(Exception):
    """The message is the folder that is missing."""


def is_description(name: str) -> bool:
    """Return whether this could be the name of a robot in `robot_descriptions`."""
    return re.fullmatch(r"[a-z]\w*_description", name) is not None


def description_path(name: str) -> Path:
    """Return the URDF of a robot of `robot_descriptions`, such as ur5_description, whose files are there already.

    The package's modules clone a repository when they are imported. Here they run with a function that only looks.
    Raises ValueError with the remedy if the package, the name or the files are missing.
    """
    if importlib.util.find_spec(PACKAGE) is None:
        raise ValueError(f"{name}: pip install {PACKAGE}, or give the path of a .urdf file")
    if importlib.util.find_spec(f"{PACKAGE}.{name}") is None:
        raise ValueError(f"{name}: {PACKAGE} has no robot of that name; robot_descriptions list shows those it has")
    from unittest import mock  # loads asyncio, which few importers of this module need

    substitute = types.ModuleType(f"{PACKAGE}._cache")
    vars(substitute).update(clone_to_cache=_find_clone, get_head_sha=lambda path: None)
    clone = f'python -c "import {PACKAGE}.{name}"'
    try:
        with mock.patch.dict(sys.modules, {substitute.__name__: substitute}):
            found = runpy.run_module(f"{PACKAGE}.{name}")
    except _NotCloned as error:
        raise ValueError(f"{name}: its files are not in {error}; fetch them: {clone}") from None
    if "URDF_PATH" not in found:
        xacro = f": it is xacro, {found['XACRO_PATH']}" if "XACRO_PATH" in found else ""
        raise ValueError(f"{name} has no URDF{xacro}")
    path = Path(found["URDF_PATH"])
    if not path.is_file():
        raise ValueError(f"{name}: there is no {path}; fetch it: {clone}")
    return path


def _find_clone(repository: str, commit: str | None = None) -> str:
    """Stands for the package's clone_to_cache. Raises _NotCloned."""
    from robot_descriptions._repositories import REPOSITORIES  # type: ignore[import-not-found]

    known = REPOSITORIES[repository].cache_path
    cache = Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", CACHE)).expanduser()
    folder = cache / (known if commit is None else f"{known}-{commit}/{known}")
    if not folder.is_dir():
        raise _NotCloned(folder)
    return str(folder)


def require_urdf(name: str | Path) -> None:
    """Raise ValueError, with the command that converts it, if this is the path of another format."""
    path = Path(name)
    kind = SUFFIXES.get(path.suffix.lower()) or (_kind_of_xml(path) if path.suffix.lower() == ".xml" else None)
    if kind is None:
        return
    if kind == "URDF":
        words = shlex.join(["cp", str(path), str(path.with_suffix(".urdf"))])
        raise ValueError(f"{path} is a URDF by another name: {words}")
    out = path.with_name(re.sub(r"(\.urdf)?\.\w+$", "", path.name) + ".urdf")
    raise ValueError(_conversion(path, kind, out))


def require_urdf_content(path: Path, root: ElementTree.Element) -> None:
    """Raise ValueError, in the same way, if the root element of a .urdf file is of another format.

    Elements of xacro are harmless in a file that has joints.
    """
    kind = ROOTS.get(root.tag)
    if kind == "URDF" and root.find("joint") is None and any(XACRO in str(element.tag) for element in root.iter()):
        kind = "xacro"
    if kind in COMMANDS:
        raise ValueError(_conversion(path, kind, path.with_name(f"{path.stem}-converted.urdf")))
    if kind is None:
        raise ValueError(f"{path}: not a URDF: its root element is <{root.tag}>, not <robot>")


def _conversion(path: Path, kind: str, out: Path) -> str:
    quoted = {"quoted": shlex.quote(str(path)), "quoted_out": shlex.quote(str(out))}
    return f"{path} is {kind}, not URDF; convert it: {COMMANDS[kind].format(file=path, out=out, **quoted)}"


def _kind_of_xml(path: Path) -> str:
    """MJCF, which usually ends in .xml, unless the root element tells otherwise."""
    try:
        require_file(path, MAX_BYTES)
        with path.open("rb") as file:
            start = file.read(MAX_SNIFFED_BYTES)
    except (OSError, ValueError):
        return "MJCF"
    root = re.search(rb"<([a-zA-Z]+)[\s>]", re.sub(rb"<!--.*?-->", b"", start, flags=re.DOTALL))
    return ROOTS.get(root[1].decode(), "MJCF") if root else "MJCF"
