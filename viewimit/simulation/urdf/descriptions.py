"""Robots of the package `robot_descriptions`, where that is installed and has their files already.

Its modules clone a repository when they are imported. Here they are run with one in its place that only looks.
"""

import importlib.util
import os
import re
import runpy
import sys
import types
from pathlib import Path

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
