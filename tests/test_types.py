"""What the code says of its types is true: mypy over the package as it is installed, and the examples that use it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.mark.skipif(sys.version_info < (3, 11), reason="the last NumPy there has narrower types of shapes")
def test_the_type_checker_finds_nothing(tmp_path):
    package = tmp_path / "viewimit"
    shutil.copytree(ROOT / "viewimit", package)
    for inside in ("app", "assets"):  # where they are installed
        shutil.copytree(ROOT / inside, package / inside)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    shutil.copytree(ROOT / "examples", tmp_path, dirs_exist_ok=True)
    what = ["-p", "viewimit", *(word for path in (ROOT / "examples").glob("*.py") for word in ("-m", path.stem))]
    command = [sys.executable, "-m", "mypy", *what, "--cache-dir", os.devnull]  # nobody reads it again
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert found.returncode == 0, found.stdout + found.stderr
