"""Descriptions of robots that are no URDF: what converts them."""

import re
import shlex
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from ...sensing.files import MEGABYTE, require_file

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
