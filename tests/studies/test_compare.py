"""All laws begin from the same draws, and the runs of the documentation are repeated."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from viewimit.experiments.bench import Draw, report
from viewimit.experiments.bench.cases import posed
from viewimit.experiments.bench.engine import Case, run_once
from viewimit.servo import SERVOS

DOCS = Path(__file__).parents[2] / "docs"


def test_every_law_begins_with_the_same_bodies_images_and_noise(compared, exact):
    named = lambda settings, servo: msgspec.structs.replace(settings, servo=servo)
    for case in compared:
        opened = [case.open(Draw(named(exact, law), 1, 3, case.generator(3, 1), None, 5)).snapshot for law in SERVOS]
        for moment in opened[1:]:
            assert named(moment.settings, "broyden") == named(opened[0].settings, "broyden")
            for name in ("own", "demo", "visible"):
                np.testing.assert_array_equal(getattr(moment.views, name), getattr(opened[0].views, name))
        assert opened[0].views.visible.all() == ("hidden" not in case.name)


@pytest.mark.parametrize("servo, draw", [("broyden", 55), ("kalman", 107), ("gauss-newton", 64)])
def test_a_law_that_rests_far_off_comes_near_when_it_begins_again(compared, exact, servo, draw):
    once, again = (run_once(case, exact, servo, 0, draw, 200) for case in (Case("once", posed), compared[0]))
    assert once.error_deg > 10 and once.motions < again.motions
    assert again.error_deg < 0.5 and again.status == "settled"


def test_runs_of_the_documentation_are_repeated(compared, exact):
    kept = report.read_runs(DOCS / "comparison.csv")
    assert {run.case for run in kept} == {case.name for case in compared}
    for servo in ("broyden", "gauss-newton", "generative", "oracle-ibvs", "oracle-pbvs-1deg"):
        run = next(run for run in kept if run.servo == servo and run.case == compared[0].name)
        again = run_once(compared[0], exact, servo, 0, run.number, 200)
        assert (again.motions, again.status) == (run.motions, run.status)
        assert again.error_deg == pytest.approx(run.error_deg, rel=1e-3, abs=1e-3)
