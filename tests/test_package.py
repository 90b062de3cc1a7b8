"""What is installed: the wheel holds all that runs and metadata that hold on a package index."""

import doctest
import os
import shutil
import subprocess
import sys
import tarfile
import venv
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


def test_the_example_of_the_package_s_help_prints_what_it_says():
    failed, tried = doctest.testmod(viewimit)
    assert tried >= 8 and failed == 0


def test_the_wheel_holds_every_file_of_the_package(wheel):
    for folder, inside in FOLDERS.items():
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and path.suffix != ".pyc":
                assert (wheel / inside / path.relative_to(ROOT / folder)).is_file(), path
    assert (wheel / "viewimit/py.typed").is_file()
    assert {path.name.partition("-")[0] for path in wheel.iterdir()} == {"viewimit"}


def test_an_sdist_holds_what_the_wheel_is_made_of_and_is_built_without_a_warning(tmp_path):
    copied(tmp_path)
    (tmp_path / "tests").mkdir()
    shutil.copy(ROOT / "tests/test_package.py", tmp_path / "tests")
    code = "import sys; from setuptools import build_meta; print(build_meta.build_sdist('made'), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower(), done.stdout + done.stderr
    with tarfile.open(next((tmp_path / "made").glob("*.tar.gz"))) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    wanted = {path for folder in (*FOLDERS, *BESIDE) for path in (tmp_path / folder).rglob("*") if path.is_file()}
    assert {path.relative_to(tmp_path).as_posix() for path in wanted} | set(FILES) <= held
    assert not any(name.startswith("tests/") for name in held)


def test_the_wheel_runs(wheel, tmp_path):
    code = (
        "import sys, viewimit.commands.cli; print(viewimit.__file__); sys.exit(viewimit.commands.cli.main(['imitate']))"
    )
    there = os.environ | {"PYTHONPATH": str(wheel)}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=there, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    where, *said = done.stdout.splitlines()
    assert where == str(wheel / "viewimit/__init__.py") and "converged" in said[1]


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


@pytest.mark.parametrize("mode", ["lenient", "strict"])
def test_an_editable_install_runs(tmp_path, mode):
    clone, site = copied(tmp_path / "clone"), tmp_path / "venv"
    code = "import sys, setuptools.build_meta as b; b.build_editable(sys.argv[1], {'editable_mode': sys.argv[2]})"
    done = subprocess.run([sys.executable, "-c", code, tmp_path, mode], cwd=clone, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    venv.create(site)
    python = site / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    where = [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    packages = subprocess.run(where, capture_output=True, text=True, check=True).stdout.strip()
    with zipfile.ZipFile(next(tmp_path.glob("*.whl"))) as archive:
        archive.extractall(packages)
    runs = """import sys
sys.path.append(sys.argv[1])  # what viewimit needs
from viewimit.app.lab.page import lab_page
import viewimit.assets
print(len(lab_page()), viewimit.assets.ROOT)"""
    command = [python, "-c", runs, Path(pytest.__file__).parents[1]]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    size, assets = ran.stdout.split()
    assert int(size) > 100_000 and Path(assets).is_relative_to(clone)


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
    assert pybullet_has_wheel()
    monkeypatch.setattr(field, value)
    assert not pybullet_has_wheel()
