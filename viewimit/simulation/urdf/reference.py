"""How a robot of a person's own is named: the path of a URDF, and which chain of it is the arm.

`arm.urdf`, or `arm.urdf#base=torso&tip=left_hand`, as a part of a document is named in an address; what of a link's
name would be read as more than a name stands there as in an address, too: %26 for &.
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

PARTS = ("base", "tip")
ENDING = r"\.urdf(?:#(.*))?$"  # of a path, which may have # in it
QUOTED = str.maketrans({letter: f"%{ord(letter):02X}" for letter in "%&#"})


@dataclass(frozen=True)
class Reference:
    """base, tip: links between which the arm is; None leaves that to `chain.find_arm`."""

    path: Path
    base: str | None = None
    tip: str | None = None

    def __str__(self) -> str:
        parts = {part: getattr(self, part) for part in PARTS}
        named = [f"{part}={link.translate(QUOTED)}" for part, link in parts.items() if link is not None]
        return f"{self.path}#{'&'.join(named)}" if named else str(self.path)


def is_reference(name: object) -> bool:
    """Whether a robot is named by a URDF."""
    return re.search(ENDING, str(name), re.IGNORECASE) is not None


def parse_reference(name: str | Path) -> Reference:
    """Raises ValueError for what stands after # and is neither a base nor a tip."""
    found = re.search(ENDING, str(name), re.IGNORECASE)
    fragment = found[1] if found and found[1] else ""
    path = str(name).removesuffix(f"#{fragment}")
    parts = {part.partition("=")[0]: unquote(part.partition("=")[2]) for part in fragment.split("&") if part}
    if wrong := [part for part, link in parts.items() if part not in PARTS or not link]:
        raise ValueError(f"{path}: #{wrong[0]} is not read: say {path}#base=LINK&tip=LINK, or one of the two")
    return Reference(Path(path), parts.get("base"), parts.get("tip"))


# Robots of the package `robot_descriptions`, where that is installed and has their files already.
# Its modules clone a repository when they are imported. Here they are run with one in its place that only looks.

PACKAGE = "robot_descriptions"
CACHE = "~/.cache/robot_descriptions"


class NotCloned(Exception):
    """The message is the folder that is not there."""


def is_description(name: str) -> bool:
    """Whether a name is of the kind that the package has."""
    return re.fullmatch(r"[a-z]\w*_description", name) is not None


def description_path(name: str) -> Path:
    """The URDF of a robot by its name in the package, such as ur5_description.

    Raises ValueError with what to do if the package, the name or the files are not there.
    """
    if importlib.util.find_spec(PACKAGE) is None:
        raise ValueError(f"{name}: pip install {PACKAGE}, or give the path of a .urdf file")
    if importlib.util.find_spec(f"{PACKAGE}.{name}") is None:
        raise ValueError(f"{name}: {PACKAGE} has no robot of that name; robot_descriptions list shows those it has")
    from unittest import mock  # loads asyncio, as few who import this need

    looking = types.ModuleType(f"{PACKAGE}._cache")
    vars(looking).update(clone_to_cache=_cloned, get_head_sha=lambda path: None)
    clone = f'python -c "import {PACKAGE}.{name}"'
    try:
        with mock.patch.dict(sys.modules, {looking.__name__: looking}):
            found = runpy.run_module(f"{PACKAGE}.{name}")
    except NotCloned as error:
        raise ValueError(f"{name}: its files are not in {error}; fetch them: {clone}") from None
    if "URDF_PATH" not in found:
        raise ValueError(
            f"{name} has no URDF" + (f": it is xacro, {found['XACRO_PATH']}" if "XACRO_PATH" in found else "")
        )
    path = Path(found["URDF_PATH"])
    if not path.is_file():
        raise ValueError(f"{name}: there is no {path}; fetch it: {clone}")
    return path


def _cloned(repository: str, commit: str | None = None) -> str:
    """As the package's own of that name, for what is there already. Raises NotCloned."""
    from robot_descriptions._repositories import REPOSITORIES  # type: ignore[import-not-found]

    known = REPOSITORIES[repository].cache_path
    cache = Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", CACHE)).expanduser()
    folder = cache / (known if commit is None else f"{known}-{commit}/{known}")
    if not folder.is_dir():
        raise NotCloned(folder)
    return str(folder)


# Descriptions of robots that are no URDF: what converts them.

MOST_BYTES = 32 * MEGABYTE
MOST_LOOKED_AT = 4000  # bytes, of a file whose name does not say what it is
COMMANDS = {
    "xacro": "pip install xacrodoc && xacrodoc {quoted} -o {quoted_out}",
    "MJCF": "pip install mjcf-urdf-simple-converter && "
    "python -c \"from mjcf_urdf_simple_converter import convert; convert('{file}', '{out}')\"",
    "SDF": 'python -c "import pybullet as p; from pybullet_utils.urdfEditor import UrdfEditor as E; '
    "p.connect(p.DIRECT); e = E(); e.initializeFromBulletBody(p.loadSDF('{file}')[0], 0); e.saveUrdf('{out}')\"",
}
SUFFIXES = {".xacro": "xacro", ".mjcf": "MJCF", ".sdf": "SDF"}
ROOTS = {"mujoco": "MJCF", "sdf": "SDF", "robot": "URDF"}  # elements of .xml files
XACRO = "xacro}"  # how the names of its elements begin, behind an address


def require_urdf(name: str | Path) -> None:
    """Raises ValueError, with the command that converts it, for the path of another description of a robot."""
    path = Path(name)
    kind = SUFFIXES.get(path.suffix.lower()) or (_kind_of_xml(path) if path.suffix.lower() == ".xml" else None)
    if kind is None:
        return
    if kind == "URDF":
        words = shlex.join(["cp", str(path), str(path.with_suffix(".urdf"))])
        raise ValueError(f"{path} is a URDF by another name: {words}")
    out = path.with_name(re.sub(r"(\.urdf)?\.\w+$", "", path.name) + ".urdf")
    raise ValueError(_converting(path, kind, out))


def require_urdf_content(path: Path, root: ElementTree.Element) -> None:
    """The same for a file that is named as a URDF, by its root element. What xacro leaves of itself does no harm where
    there are joints."""
    kind = ROOTS.get(root.tag)
    if kind == "URDF" and root.find("joint") is None and any(XACRO in str(element.tag) for element in root.iter()):
        kind = "xacro"
    if kind in COMMANDS:
        raise ValueError(_converting(path, kind, path.with_name(f"{path.stem}-converted.urdf")))
    if kind is None:
        raise ValueError(f"{path}: not a URDF: its root element is <{root.tag}>, not <robot>")


def _converting(path: Path, kind: str, out: Path) -> str:
    quoted = {"quoted": shlex.quote(str(path)), "quoted_out": shlex.quote(str(out))}
    return f"{path} is {kind}, not URDF; convert it: {COMMANDS[kind].format(file=path, out=out, **quoted)}"


def _kind_of_xml(path: Path) -> str:
    """MJCF, which has that name, unless its root element says otherwise."""
    try:
        require_file(path, MOST_BYTES)
        with path.open("rb") as file:
            start = file.read(MOST_LOOKED_AT)
    except (OSError, ValueError):
        return "MJCF"
    root = re.search(rb"<([a-zA-Z]+)[\s>]", re.sub(rb"<!--.*?-->", b"", start, flags=re.DOTALL))
    return ROOTS.get(root[1].decode(), "MJCF") if root else "MJCF"
