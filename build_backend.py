"""How wheels are built: as setuptools does, with two additions.

With VIEWIMIT_DOCS=1 a wheel holds the documentation, whose examples are executed for it; a release sets it. Without it
nothing of the documentation is asked for, so it cannot keep anybody from installing.

An editable install imports app/ and assets/ as parts of viewimit through a hook, which no editor and no type checker
runs. For them build/editable/ holds links to all parts, and a .pth file adds it to `sys.path`. Python itself finds
nothing there, so that programs import the files, not the links.
"""

import base64
import csv
import hashlib
import io
import os
import re
import shutil
import zipfile
from pathlib import Path

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

HERE = Path(__file__).parent
NEEDLESS = {"viser", "websockets", "segno"}  # of the page
LINKS = HERE / "build" / "editable"
BESIDE = ("app", "assets")  # folders that install inside viewimit


def get_requires_for_build_wheel(config_settings=None):
    return [*build_meta.get_requires_for_build_wheel(config_settings), *documentation_needs()]


def documentation_needs():
    """Requirements of docs/build.py; none where the documentation is not built."""
    if os.environ.get("VIEWIMIT_DOCS") != "1":
        return []
    said = tomllib.loads((HERE / "pyproject.toml").read_text("utf-8"))
    needs = [*said["project"]["dependencies"], *said["dependency-groups"]["docs"]]
    return [need for need in needs if re.match(r"[\w.-]+", need)[0] not in NEEDLESS]


NOTHING_THERE = """import sys


class Nothing:
    @staticmethod
    def find_spec(name, target=None):
        return None


def hook(path):
    if path != {path!r}:
        raise ImportError
    return Nothing


sys.path_hooks.insert(0, hook)
"""


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    name = build_meta.build_editable(wheel_directory, config_settings, metadata_directory)
    link_parts(LINKS / "viewimit")
    added = {
        "__editable___viewimit_links.py": NOTHING_THERE.format(path=str(LINKS)),
        "__editable___viewimit_links.pth": f"import __editable___viewimit_links\n{LINKS}\n",
    }
    add_files(Path(wheel_directory) / name, added)
    return name


def link_parts(folder):
    """Make a folder of links to everything in viewimit/, to app/ and to assets/."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for part in [*(HERE / "viewimit").iterdir(), *(HERE / name for name in BESIDE)]:
        if part.name != "__pycache__":
            link(part, folder / part.name)


def link(target, place):
    """A symbolic link; where Windows forbids it to users, a junction to a folder or a hard link to a file."""
    try:
        place.symlink_to(target, target.is_dir())
    except OSError:
        if not target.is_dir():
            os.link(target, place)
            return
        import _winapi

        _winapi.CreateJunction(str(target), str(place))


def add_files(wheel, added):
    """Add texts by name at the top of a wheel, and to its record."""
    with zipfile.ZipFile(wheel) as archive:
        files = {info: archive.read(info) for info in archive.infolist()}
    (record,) = (info for info in files if info.filename.endswith(".dist-info/RECORD"))
    rows = io.StringIO()
    for name, content in added.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content.encode()).digest()).rstrip(b"=").decode()
        csv.writer(rows, lineterminator="\n").writerow([name, f"sha256={digest}", len(content.encode())])
    files[record] = rows.getvalue().encode() + files[record]
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in [*added.items(), *files.items()]:
            archive.writestr(name, data)
