"""One run, one verdict: each preset of the lab in every front end that can compute it.

`python tests/lab/test_verdicts.py` prints the table without a browser.
"""

import contextlib
import io

import pytest
from viewimit.app.lab.page import lab_page
from viewimit.app.presets import LAB_PRESETS

from viewimit import Session
from viewimit.commands import imitate
from viewimit.drawing.export.lab_methods import lab_methods
from viewimit.drawing.export.recording import record
from viewimit.drawing.status import DOTS, SHAPES, describe
from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS, ServoStatus, verdict, verdicts

MOTIONS = 1000
PLAYED = """motions => { const s = lab.session(); while (s.now.motion < motions && s.step()); lab.draw();
const said = document.getElementById("outcome"), dot = document.getElementById("state").className.split(" ").pop();
return [said.textContent.replace(/[.]$/, ""), dot, s.now.status]; }"""
IN_REPLAY = """() => [document.getElementById("outcome").textContent,
document.getElementById("state").className.split(" ").pop()]"""
PRESETS = {preset.key: preset for preset in LAB_PRESETS if preset.key not in ("printed", "four")}
# One crawls on for thousands of steps, the other has a body that the library's scene has not


def run_of(preset):
    session = Session(preset.settings)
    return session, session.run(MOTIONS)


def in_python(session, ended):
    """(label, dot) of the page, the command line and the file of a replay."""
    said = describe(session.snapshot, joints=session.scene.moving_joints)
    printed = io.StringIO()
    with contextlib.redirect_stderr(printed):
        imitate.tell(ended)
    recorded = record(session, [session.snapshot.motion], None)["snapshots"][-1]
    dots = {drawn: name for name, drawn in DOTS.items()}
    told = printed.getvalue().removeprefix("viewimit imitate: ").split(".")[0]
    return {
        "page": (said.title, dots[SHAPES[said.state]]),
        "imitate": (told, verdict(ended.status).dot),
        "replay": (recorded["title"], verdict(ServoStatus(recorded["state"])).dot),
    }


def test_green_is_a_claim_and_nothing_else():
    assert set(verdicts()) == set(ServoStatus)
    assert [status for status, told in verdicts().items() if told.dot == "green"] == [ServoStatus.CONVERGED]


def test_the_lab_offers_methods_of_the_library():
    assert set(lab_methods().servos) <= set(SERVOS) and set(lab_methods().transfers) <= set(TRANSFERS)
    assert all(one.settings.servo in lab_methods().servos for one in LAB_PRESETS)
    assert all(one.settings.transfer in lab_methods().transfers for one in LAB_PRESETS)


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    path = tmp_path_factory.mktemp("verdicts") / "lab.html"
    path.write_text(lab_page(), "utf-8")
    page = browser.new_context().new_page()
    page.goto(path.as_uri())
    page.locator("#outcome:not(:empty)").wait_for()
    yield page
    page.context.close()


@pytest.mark.parametrize("name", PRESETS)
def test_every_front_end_says_the_same_of_a_run(opened, name):
    session, ended = run_of(PRESETS[name])
    expected = verdict(ended.status).label, verdict(ended.status).dot
    opened.locator("#preset").select_option(name)
    *shown, status = opened.evaluate(PLAYED, MOTIONS)
    assert status == ended.status
    assert {tuple(shown), *in_python(session, ended).values()} == {expected}


def main():
    for preset in PRESETS.values():
        session, ended = run_of(preset)
        told = in_python(session, ended)
        same = "same" if len(set(told.values())) == 1 else "DIFFERENT"
        row = f"{preset.key:9} {ended.motions:5} {ended.status:12} {same:9}"
        print(row, *map(" / ".join, told.values()), sep=" | ")


if __name__ == "__main__":
    main()
