"""What is installed: the wheel holds all that runs, and metadata that hold on a package index."""

import os
import shutil
import subprocess
import sys
import zipfile
from email import message_from_string
from pathlib import Path

import pytest

from viewimit.simulation.eyes import has_wheel

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
FOLDERS = {"viewimit": "viewimit", "app": "viewimit/app", "assets": "viewimit/assets"}  # where they install
FILES = ("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Built from a copy, so that no build folder is left behind."""
    source, made = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("made")
    for folder in FOLDERS:
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in FILES:
        shutil.copy(ROOT / name, source)
    command = [sys.executable, "-m", "pip", "wheel", "-v", "--no-deps", "--wheel-dir", str(made), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=os.environ | {"PYTHONWARNINGS": ""})
    if "No matching distribution found for setuptools" in done.stdout + done.stderr:
        pytest.skip("no package index")
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


def test_the_wheel_runs(wheel, tmp_path):
    code = "import sys, viewimit.cli; print(viewimit.__file__); sys.exit(viewimit.cli.main(['imitate']))"
    there = os.environ | {"PYTHONPATH": str(wheel)}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=there, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    where, *said = done.stdout.splitlines()
    assert where == str(wheel / "viewimit/__init__.py") and "converged" in said[1]


def test_its_metadata_hold_on_an_index(wheel):
    (path,) = wheel.glob("*.dist-info/METADATA")
    metadata = message_from_string(path.read_text("utf-8"))
    assert metadata["License-Expression"] == "MIT" and len(metadata.get_all("License-File")) == 4
    assert any(name == "Typing :: Typed" for name in metadata.get_all("Classifier"))
    text = metadata.get_payload()
    assert metadata["Description-Content-Type"] == "text/markdown" and "# viewimit\n" in text and "## Glossary" in text
    assert "![" not in text and "\n!" not in text
    assert "](docs/" not in text and "](LICENSE)" not in text and "see LICENSE." in text


def test_what_camera_images_need_comes_by_one_marker():
    markers = pytest.importorskip("packaging.markers")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    by_name = dict(dependency.partition("; ")[::2] for dependency in project["dependencies"])
    marker = by_name["pybullet>=3.2.7"]
    assert by_name["opencv-python-headless>=4.8"] == marker
    assert markers.Marker(marker).evaluate() == has_wheel()
    here = {"python_version": "3.11", "platform_python_implementation": "CPython", "sys_platform": "linux"}
    assert markers.Marker(marker).evaluate(here | {"platform_machine": "x86_64"})
    for other in ({"python_version": "3.12"}, {"sys_platform": "darwin"}, {"platform_machine": "aarch64"}):
        assert not markers.Marker(marker).evaluate(here | {"platform_machine": "x86_64"} | other)


@pytest.mark.parametrize(
    "field, value",
    [
        ("platform.python_implementation", lambda: "PyPy"),
        ("platform.machine", lambda: "aarch64"),
        ("sys.platform", "darwin"),
        ("sys.version_info", (3, 12, 1)),
    ],
)
def test_there_is_no_wheel_of_pybullet_elsewhere(monkeypatch, field, value):
    for name, here in (("machine", "x86_64"), ("python_implementation", "CPython")):
        monkeypatch.setattr(f"platform.{name}", lambda here=here: here)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("sys.version_info", (3, 11, 7))
    assert has_wheel()
    monkeypatch.setattr(field, value)
    assert not has_wheel()
