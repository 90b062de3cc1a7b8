"""What the code says of its types is true: mypy over the package as it is installed, and the examples that use it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.mark.skipif(sys.version_info < (3, 11), reason="the last NumPy there has narrower types of shapes")
@pytest.mark.parametrize("platform", ["linux", pytest.param("win32", marks=pytest.mark.slow)])
def test_the_type_checker_finds_nothing(tmp_path, platform):
    """A name that a system lacks, such as os.nice on Windows, is one that it finds."""
    package = tmp_path / "viewimit"
    shutil.copytree(ROOT / "viewimit", package)
    for inside in ("app", "assets"):  # where they are installed
        shutil.copytree(ROOT / inside, package / inside)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    shutil.copytree(ROOT / "examples", tmp_path, dirs_exist_ok=True)
    what = ["-p", "viewimit", *(word for path in (ROOT / "examples").glob("*.py") for word in ("-m", path.stem))]
    command = [sys.executable, "-m", "mypy", *what, "--platform", platform, "--cache-dir", os.devnull]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert found.returncode == 0, found.stdout + found.stderr


LEAST_COMPLETE = 0.95  # share of the library's public names whose types are all known


def test_public_types_are_complete(tmp_path):
    pytest.importorskip("basedpyright")
    shutil.copytree(ROOT / "viewimit", tmp_path / "viewimit")
    shutil.copytree(ROOT / "assets", tmp_path / "viewimit" / "assets")
    found = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])  # whose packages are used
    done = subprocess.run(
        [sys.executable, "-m", "basedpyright", "--verifytypes", "viewimit", "--ignoreexternal", "--outputjson"],
        cwd=tmp_path,
        env=os.environ | {"PATH": found, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    report = json.loads(done.stdout)["typeCompleteness"]
    unknown = [symbol["name"] for symbol in report["symbols"] if symbol["isExported"] and not symbol["isTypeKnown"]]
    assert report["completenessScore"] > LEAST_COMPLETE, "\n".join(unknown)
