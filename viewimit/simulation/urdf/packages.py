"""Where the meshes are that a URDF names, and that nothing else is read.

Relative paths are those from its folder. `package://name/…` is sought in the folders above it, themselves of that name
or with one of that name in them, and along ROS_PACKAGE_PATH. What lies elsewhere, and what has an address on a network,
is refused.
"""

import os
import re
from pathlib import Path
from urllib.parse import unquote

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
