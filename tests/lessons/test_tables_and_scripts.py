"""Tables of figures and measures are those of the scripts, and a handout prints the numbers that a browser shows."""

import json
import subprocess
from pathlib import Path

import pytest
import typescript
from viewimit.app.lab.lessons import page, source
from viewimit.app.lab.lessons.checks import figure_kinds, measure_table
from viewimit.app.lab.lessons.format import Step, measures_of
from viewimit.app.lab.lessons.handout import situation_on_paper
from viewimit.app.lab.lessons.paper_measures import PAPER_MEASURES

HERE = Path(__file__).parent
SCRIPTS = HERE.parent.parent / "app" / "lab" / "lessons"
LESSONS = source.shipped()
BROWSER = measure_table()["browser"]


def is_dealt(name: str, step: Step) -> bool:
    return step.randomise or any(other.id == step.carry and other.randomise for other in LESSONS[name].step)


ASKED = [
    (name, step.id, measure)
    for name, lesson in LESSONS.items()
    for step in lesson.step
    for measure in measures_of(step)
    if measure in BROWSER and measure in PAPER_MEASURES and not is_dealt(name, step)
]


@pytest.fixture(scope="module")
def found():
    asked = {"page": page.page_data({name: LESSONS[name] for name in ("ray", "tour", "limits")}), "asked": ASKED}
    command = [typescript.node(), str(HERE / "measured.mjs"), str(SCRIPTS)]
    done = subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_every_figure_is_drawn_with_all_layers_that_a_file_can_name(found):
    assert found["figures"].keys() == figure_kinds().keys()
    for name, kind in figure_kinds().items():
        assert set(kind.layers) <= set(found["figures"][name]), name


def test_every_measure_of_a_browser_is_computed_there(found):
    assert set(BROWSER) <= set(found["measures"])


def test_paper_has_the_numbers_of_the_browser(found):
    assert len(ASKED) > 15
    told = []
    for name, step_id, measure in ASKED:
        step = next(one for one in LESSONS[name].step if one.id == step_id)
        told.append(PAPER_MEASURES[measure].tell(situation_on_paper(LESSONS[name], step))["text"])
    assert dict(zip(ASKED, told)) == dict(zip(ASKED, found["texts"]))
