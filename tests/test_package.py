"""What is installed: the wheel holds all that runs and metadata that hold on a package index."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

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
