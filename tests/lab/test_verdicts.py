"""One run, one verdict: each preset of the lab in every front end that can compute it."""

import contextlib
import functools
import io

import msgspec
import pytest
from browsing import sparing
from viewimit.app.classroom.server import ENTRY as CLASS
from viewimit.app.lab.lessons.format import Lesson
from viewimit.app.lab.lessons.page import ENTRY as LESSONS
from viewimit.app.lab.lessons.page import lesson_page
from viewimit.app.lab.lessons.records import MAX_MOTIONS
from viewimit.app.lab.lessons.sign import signed_runs
from viewimit.app.lab.lessons.source import shipped
from viewimit.app.lab.page import lab_page
from viewimit.app.lab.recording import lab_methods, record
from viewimit.app.presets import LAB_PRESETS

from viewimit import Session
from viewimit.commands import imitate
from viewimit.drawing.status import DOTS, SHAPES, describe
from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS, ServoStatus, verdict, verdicts

MOTIONS = 1000
PLAYED = """motions => { const s = lab.session(); while (s.now.motion < motions && s.step()); lab.draw();
const said = document.getElementById("outcome"), dot = document.getElementById("state").className.split(" ").pop();
return [said.textContent.replace(/[.]$/, ""), dot, s.now.status]; }"""
SAID = """kind => { lesson.draw(); const [, label, says] = document.querySelector(`.lesson-says-${kind}`).children;
return [label.textContent, label.firstElementChild.className.split(" ").pop(), says.textContent]; }"""
RACED = f"name => {{ lesson.goTo('runs', name); lesson.stage().reveal = 1; return ({SAID})('learner'); }}"
SIGNED = f"""run => {{ lesson.goTo('sign', 'sign'); lesson.stage().run = run;
return [...({SAID})('plain'), lesson.stage().records.runs[run].claim]; }}"""
PRESETS = {preset.key: preset for preset in LAB_PRESETS if preset.key not in ("printed", "four")}
# One crawls on for thousands of steps, the other has a body that the library's scene has not


@functools.cache
def run_of(name):
    session = Session(PRESETS[name].settings)
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
    page = sparing(browser.new_context()).new_page()
    page.goto(path.as_uri())
    page.locator("#outcome:not(:empty)").wait_for()
    yield page
    page.context.close()


@pytest.mark.browser
@pytest.mark.parametrize("name", PRESETS)
def test_every_front_end_says_the_same_of_a_run(opened, name):
    session, ended = run_of(name)
    expected = verdict(ended.status).label, verdict(ended.status).dot
    opened.locator("#preset").select_option(name)
    *shown, status = opened.evaluate(PLAYED, MOTIONS)
    assert status == ended.status
    assert {tuple(shown), *in_python(session, ended).values()} == {expected}


def lesson_of_presets():
    """One step a preset: its servo runs from the start, and the step tells how it ended."""
    ask = {"kind": "do", "question": "?", "measure": "E", "below": 1e-12}  # a goal that no run reaches before it rests
    steps = [
        {
            **{"id": preset.key, "title": preset.key, "text": "?", "say": "!", "ask": ask},
            **{"settings": msgspec.to_builtins(preset.settings), "race": [preset.settings.servo]},
            **{"main": [{"figure": "verdict", "reveal": ["learner"]}]},
        }
        for preset in PRESETS.values()
    ]
    return msgspec.convert({"title": "?", "short": "?", "about": "?", "minutes": 1, "step": steps}, Lesson)


@pytest.mark.browser
@pytest.mark.parametrize("entry", [LESSONS, CLASS])
def test_lessons_and_a_class_say_the_same_of_a_run(browser, entry):
    html = lesson_page({"runs": lesson_of_presets(), "sign": shipped()["sign"]}, entry)
    page = browser.new_context(reduced_motion="reduce").new_page()
    page.route("**/*", lambda route: route.fulfill(content_type="text/html", body=html))
    page.goto("http://lessons.test/")
    page.wait_for_function("() => globalThis.lesson")
    for name in PRESETS:
        if name == "retuned":  # rests after more steps than a lesson plays
            continue
        _, run = run_of(name)
        assert run.motions <= MAX_MOTIONS
        expected = verdict(run.status)
        sentence = expected.sentence(run.motions, run.last.E, int(run.last.usable.sum()))
        assert page.evaluate(RACED, name) == [expected.label, expected.dot, sentence], name
    for k, signed in enumerate(signed_runs()):
        label, dot, says, claim = page.evaluate(SIGNED, k)
        last, expected = signed.session.snapshot, verdict(claim["status"])
        assert (claim["status"], label, dot) == (last.status, expected.label, expected.dot), signed.name
        joints = " and the ".join(("shoulder", "elbow")[joint] for joint in claim["unobservable"])
        sentence = expected.sentence(last.motion, last.E, claim["seen"], f"the {joints}", claim["expectedOffDeg"])
        assert says == sentence, signed.name
    page.context.close()
