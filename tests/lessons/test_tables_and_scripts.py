"""Tables of figures and measures are those of the scripts."""

import json
import subprocess
from pathlib import Path

import pytest
import typescript
from viewimit.app.lab.lessons.checks import figure_kinds, measure_table

HERE = Path(__file__).parent
SCRIPTS = HERE.parent.parent / "app" / "lab" / "lessons"
BROWSER = measure_table()["browser"]


@pytest.fixture(scope="module")
def found():
    command = [typescript.node(), str(HERE / "measured.mjs"), str(SCRIPTS)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_every_figure_is_drawn_with_all_layers_that_a_file_can_name(found):
    assert found["figures"].keys() == figure_kinds().keys()
    for name, kind in figure_kinds().items():
        assert set(kind.layers) <= set(found["figures"][name]), name


def test_every_measure_of_a_browser_is_computed_there(found):
    assert set(BROWSER) <= set(found["measures"])
