"""What is installed: the wheel holds all that runs and metadata that hold on a package index."""

import shutil
import subprocess
import sys
import zipfile
from email import message_from_string
from pathlib import Path

import pytest

import viewimit
from viewimit.simulation.arms import pybullet_has_wheel

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
FOLDERS = {"viewimit": "viewimit", "app": "viewimit/app", "assets": "viewimit/assets"}  # where they install
BESIDE = ("docs", "examples")  # folders that the documentation is made of
FILES = (
    "pyproject.toml", "MANIFEST.in", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff",
)  # fmt: skip


def copied(folder):
    """What a wheel is made of, in a folder that may keep what a build leaves behind."""
    for part in (*FOLDERS, *BESIDE):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    for name in FILES:
        shutil.copy(ROOT / name, folder)
    return folder


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """Built from a copy, so that no build folder is left behind, by what is installed."""
    source, made = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("made")
    copied(source)
    command = [sys.executable, "-m", "pip", "wheel", "-v", "--no-deps", "--no-build-isolation", "--wheel-dir"]
    done = subprocess.run([*command, str(made), str(source)], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Package would be ignored" not in done.stdout and "Deprecat" not in done.stdout, done.stdout
    (path,) = made.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(made / "unpacked")
    return made / "unpacked"


def test_the_wheel_holds_every_file_of_the_package(wheel):
    for folder, inside in FOLDERS.items():
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and path.suffix != ".pyc":
                assert (wheel / inside / path.relative_to(ROOT / folder)).is_file(), path
    assert (wheel / "viewimit/py.typed").is_file()
    assert {path.name.partition("-")[0] for path in wheel.iterdir()} == {"viewimit"}


def test_its_metadata_hold_on_an_index(wheel):
    (path,) = wheel.glob("*.dist-info/METADATA")
    metadata = message_from_string(path.read_text("utf-8"))
    licences = metadata["License-Expression"].split(" AND ")
    assert licences == ["MIT", "Apache-2.0", "BSD-2-Clause", "OFL-1.1"]
    assert len(metadata.get_all("License-File")) == len(licences)
    assert metadata["Version"] == viewimit.__version__
    assert any(name == "Typing :: Typed" for name in metadata.get_all("Classifier"))
    text = metadata.get_payload()
    assert (
        metadata["Description-Content-Type"] == "text/markdown" and "# viewimit\n" in text and "## Two commands" in text
    )


def test_the_default_install_has_nothing_that_only_some_can_use():
    """PyBullet and OpenCV are extras; the tests take PyBullet where it has wheels."""
    markers = pytest.importorskip("packaging.markers")
    said = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    project, tests = said["project"], said["dependency-groups"]["test"]
    assert not [need for need in project["dependencies"] if need.startswith(("pybullet", "opencv"))]
    (needed,) = (need for need in tests if "pybullet" in need)
    marker = needed.partition("; ")[2]
    assert markers.Marker(marker).evaluate() == pybullet_has_wheel()
    here = {"python_version": "3.11", "platform_python_implementation": "CPython", "sys_platform": "linux"}
    assert markers.Marker(marker).evaluate(here | {"platform_machine": "x86_64"})
    for other in ({"python_version": "3.12"}, {"sys_platform": "darwin"}, {"platform_machine": "aarch64"}):
        assert not markers.Marker(marker).evaluate(here | {"platform_machine": "x86_64"} | other)
