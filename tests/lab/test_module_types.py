"""The lab's modules have the types that their comments say, by TypeScript's checker in its strict mode."""

import os
import subprocess
from pathlib import Path

import pytest
import typescript

HERE = Path(__file__).parent


def test_the_type_checker_finds_nothing():
    if not typescript.COMPILER.is_file():
        missing = "no TypeScript; `python tests/browser.py` installs it"
        (pytest.fail if os.environ.get("VIEWIMIT_REQUIRE_BROWSER") == "1" else pytest.skip)(missing)
    command = [typescript.node(), str(typescript.COMPILER), "-p", str(HERE)]
    found = subprocess.run(command, capture_output=True, text=True)
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_type_checker_finds_a_wrong_type(tmp_path):
    if not typescript.COMPILER.is_file():
        pytest.skip("no TypeScript")
    wrong = tmp_path / "wrong.js"
    wrong.write_text('/** @type {number} */\nexport const E = "small";\n')
    command = [typescript.node(), str(typescript.COMPILER), "--checkJs", "--noEmit", "--strict", str(wrong)]
    found = subprocess.run(command, capture_output=True, text=True)
    assert found.returncode != 0 and "not assignable" in found.stdout
