"""A lesson is walked through in Chromium: with the mouse, with keys alone, and with a finger on a phone."""

import pytest
import walking
from browsing import private_windows
from waiting import wait_until

pytestmark = pytest.mark.browser

SCREENS = (1280, 720), (390, 844)
STEPS = "choice", "place", "number", "servo", "bowl", "pose", "knobs", "bet"
STATE = "() => lesson.state()"
COVERED = """() => [...document.querySelectorAll('#foot button')].filter(button => {
    const {left, top, width, height} = button.getBoundingClientRect();
    return left < 0 || top < 0 || left + width > innerWidth + .5 || top + height > innerHeight + .5
        || !button.contains(document.elementFromPoint(left + width / 2, top + height / 2));
}).map(button => button.textContent)"""
NO_STORAGE = "Object.defineProperty(window, 'localStorage', {get() { throw new Error('none'); }});"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        return walking.written(tmp_path_factory.mktemp("lessons") / "walk.html", patch)


@pytest.fixture
def opened(browser, path):
    """Opens the lesson in windows of their own, which must ask nobody and have no fault."""

    def open_(step="", seed=4, size=(1280, 720), before=None, **options):
        options = {"reduced_motion": "reduce", **options}
        page = page_of(browser.new_context(viewport={"width": size[0], "height": size[1]}, **options))
        if before:
            page.add_init_script(before)
        page.goto(path.as_uri() + (f"#lesson=walk&step={step}&seed={seed}" if step else ""))
        wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
        settled(page)
        return page

    with private_windows("error", "warning") as page_of:
        yield open_


def settled(page):
    """Two frames later, all that was asked for is drawn."""
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def press(page, *keys):
    for key in keys:
        page.keyboard.press(key)
        settled(page)


def click(page, selector):
    page.click(selector)
    settled(page)


def at(page):
    return page.evaluate(STATE)


def body(page):
    return page.inner_text("#body").replace("\xa0", " ")


def steer(page, joint, degrees):
    """Set a joint of "Be the servo", which the press of Go then turns."""
    low, high = ((0, 90), (-180, 0))[joint]
    page.locator(".turned input").nth(joint).fill(str(100 * (degrees - low) / (high - low)))
    click(page, ".steered .go")


def mark(page, x=0.5, y=0.5, tap=False):
    """Click in the figure that is asked about, at shares of its width and height."""
    box = page.locator(".asked .drawing").bounding_box()
    point = box["x"] + x * box["width"], box["y"] + y * box["height"]
    page.touchscreen.tap(*point) if tap else page.mouse.click(*point)
    settled(page)


def test_it_is_walked_with_the_mouse(opened):
    page = opened("choice")
    assert page.locator("#figures .sliders").is_hidden() and page.locator(".drawing .vi-e").count() == 0
    click(page, ".option >> nth=0")
    click(page, ".primary")
    assert at(page)["revealed"] and "No: it is the second." in body(page) and "one thing" in body(page)
    assert page.locator(".option.right").count() == 1 and page.locator(".option.wrong").count() == 1
    assert page.locator(".drawing .vi-e").count() == 2 and page.locator("#figures .sliders").is_visible()
    click(page, ".primary")
    mark(page, 0.3, 0.7)
    click(page, ".primary")
    assert "Your mark and the crossing" in body(page) and "px apart" in body(page)
    assert page.locator(".marks .pill").count() == 1
    click(page, ".primary")
    page.locator(".ask input").fill("5")
    settled(page)
    click(page, ".primary")
    assert "It is more: 846 px²" in body(page)
    click(page, ".primary")
    page.evaluate("lesson.goTo('walk', 'servo', 4)")  # some of the starts are below the goal already
    settled(page)
    for k, degrees in ((0, 70), (1, -65)):
        steer(page, k, degrees)
    state = at(page)
    assert state["step"] == "servo" and state["revealed"] and len(state["motions"]) == 3
    assert "You needed 2 steps." in body(page)
    click(page, ".primary")
    mark(page)
    click(page, ".primary")
    assert at(page)["step"] == "bowl" and "Your mark and the smallest E" in body(page)
    click(page, ".primary")
    page.locator(".sliders input").nth(0).fill("61")
    page.locator(".sliders input").nth(1).fill("-117")
    settled(page)
    click(page, ".primary")
    assert "Close." in body(page) and page.locator("#figures .sliders").is_hidden()
    click(page, ".primary")
    for turn in range(2):
        page.locator(".sliders input").nth(turn).fill("8")
        mark(page, 0.4, 0.4)
        click(page, ".primary")
    state = at(page)
    assert state["revealed"] and len(state["rounds"]) == 2
    click(page, ".primary")
    for bet, penalty in (("80", "0.04"), ("20", "0.64")):
        page.locator(".ask input").fill(bet)
        settled(page)
        click(page, ".primary")
        assert penalty in body(page)
        click(page, ".primary")
    assert at(page)["step"] == "after-1"
    click(page, "text=Skip the questions")
    assert "Now you can say" in page.inner_text("#figures") and "E is a bowl." in page.inner_text("#figures")


def test_it_is_walked_with_keys_alone(opened):
    page = opened("choice")
    press(page, "2")
    assert page.locator(".option.chosen").count() == 1
    press(page, "Enter")
    assert at(page)["revealed"] and "Right: it is the second." in body(page)
    press(page, "ArrowRight")
    assert at(page)["step"] == "place"
    press(page, "ArrowUp", "ArrowUp", "Shift+ArrowLeft")
    assert at(page)["mark"]
    press(page, "Enter", "ArrowLeft")
    assert at(page)["step"] == "choice" and at(page)["revealed"]
    press(page, "ArrowRight", "ArrowRight")
    assert at(page)["step"] == "number"
    page.locator(".ask input").focus()
    press(page, "ArrowRight", "Enter")
    assert at(page)["revealed"]
    press(page, "Enter")
    page.locator(".turned input").nth(0).focus()
    press(page, *5 * ["ArrowRight"])
    assert at(page)["step"] == "servo" and len(at(page)["motions"]) == 1
    press(page, "Enter")
    assert len(at(page)["motions"]) == 2
    click(page, "#progress button >> nth=7")
    press(page, "8", "Enter")
    assert at(page)["step"] == "bet" and "80 %" in body(page)
    press(page, "Escape")
    assert at(page)["step"] == "home"


@pytest.mark.parametrize("step", ("choice", "place", "servo"))
def test_it_is_walked_with_a_finger(opened, step):
    page = opened(step, size=(390, 844), has_touch=True, is_mobile=True)
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight + 1") and page.evaluate(COVERED) == []
    picture, card = (page.locator(one).bounding_box() for one in (".drawing >> nth=0", ".card h2"))
    assert picture["y"] < card["y"] and picture["height"] > 120
    if step == "choice":
        page.tap(".option >> nth=1")
    elif step == "place":
        assert "Tap in L" in body(page) and "Click" not in body(page)
        mark(page, 0.6, 0.4, tap=True)
    else:
        page.locator(".turned input").nth(0).fill("70")
        page.tap(".nudge >> nth=1")
        page.tap(".steered .go")
    settled(page)
    page.tap(".primary")
    settled(page)
    assert at(page)["revealed"]


@pytest.mark.parametrize("size", SCREENS)
def test_nothing_scrolls_and_all_buttons_are_in_sight(opened, size):
    page = opened("choice", size=size)
    for step in STEPS:
        page.evaluate("step => lesson.goTo('walk', step, 4)", step)
        settled(page)
        for shown in (False, True):
            if shown:
                page.evaluate("lesson.reveal()")
                settled(page)
            assert page.evaluate(COVERED) == [], (step, shown)
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth && scrollY === 0"), (step, shown)
            small = "[...document.querySelectorAll('.main .drawing')].filter(e => e.clientHeight < 90).length"
            assert page.evaluate(small) == 0, (step, shown)


def test_show_me_asks_for_a_guess_first_and_then_shows(opened):
    page = opened("choice")
    click(page, ".primary")
    assert not at(page)["revealed"] and "A guess is enough" in page.inner_text("#note")
    click(page, ".primary")
    assert at(page)["revealed"] and "commit to a guess" in body(page)


def test_answers_are_kept_and_come_back(opened):
    page = opened("choice")
    press(page, "1", "Enter")
    page.reload()
    wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
    settled(page)
    assert at(page)["revealed"] and "No: it is the second." in body(page)
    assert page.locator("#progress .done").count() == 1


def test_without_storage_it_works_and_says_so(opened):
    page = opened("choice", before=NO_STORAGE)
    assert "keeps nothing" in page.inner_text("#note")
    press(page, "2", "Enter")
    assert at(page)["revealed"]


def test_the_questions_are_asked_before_and_after_and_reviewed(opened):
    page = opened("before-1")
    for phase, right in (("before", 4), ("after", 7)):
        page.evaluate("phase => lesson.goTo('walk', `${phase}-1`)", phase)
        for k in range(8):
            settled(page)
            question = page.evaluate("k => lesson.data.lessons[0].questions[k]", k)
            answer = next(one for one in question["answers"] if one["right"] == (k < right))
            click(page, f".option:has-text({answer['text']!r})" if "'" not in answer["text"] else ".option >> nth=0")
            assert page.locator(".primary").is_disabled()
            press(page, "s" if k % 2 else "g", "Enter")
    assert at(page)["step"] == "end"
    assert "4 → 7 of 8" in body(page) and "Gain 0.75" in body(page)
    rows = page.locator(".review li:not(.heads)")
    assert rows.count() == 8 and page.locator(".review .open").count() == 1


def test_a_screen_reader_hears_what_becomes_known(opened):
    page = opened("choice")
    assert page.locator("h2").evaluate("e => e === document.activeElement")
    press(page, "1", "Enter")
    wait_until(lambda: "No: it is the second." in page.inner_text("#announced"))
    assert "This is one thing to say." in page.inner_text("#announced")


def test_axe_finds_nothing_on_any_screen(opened, violations):
    page = opened("home", size=(390, 844), has_touch=True, is_mobile=True, color_scheme="dark")
    assert violations(page) == []
    for step in STEPS:
        page.evaluate("step => lesson.goTo('walk', step, 4)", step)
        settled(page)
        assert step not in ("choice", "knobs") or violations(page) == [], step
        page.evaluate("lesson.reveal()")
        settled(page)
        assert violations(page) == [], f"{step}, revealed"


def test_a_class_freezes_leads_and_shows_what_others_answered(opened):
    page = opened("choice")
    page.evaluate("window.told = []; lesson.onAnswer = (...all) => told.push(all); 0")
    press(page, "1")
    assert page.evaluate("told") == [["choice", {"choice": 0}, False]]
    page.evaluate("lesson.freeze(true)")
    settled(page)
    press(page, "2", "Enter")
    assert at(page)["answer"] == {"choice": 0} and not at(page)["revealed"]
    page.evaluate("lesson.freeze(false); lesson.hold(true)")
    settled(page)
    press(page, "2", "Enter")
    assert at(page)["answer"] == {"choice": 1} and not at(page)["revealed"]
    page.evaluate("lesson.showOthers({counts: [3, 6, 1]}); lesson.reveal()")
    settled(page)
    assert at(page)["revealed"] and "6 · 60 %" in body(page)


@pytest.mark.parametrize("how", ("shown", "revealed by others", "skipped"))
def test_a_step_goes_on_from_what_was_shown_and_not_from_an_unfinished_try(opened, how):
    """The goal is E below 30; one step leaves it far above."""
    page = opened("servo")
    steer(page, 0, 60)
    assert page.evaluate("lesson.stage().moment.E") > 30
    if how == "shown":
        click(page, ".primary")
    elif how == "revealed by others":
        page.evaluate("lesson.reveal()")
    settled(page)
    shown = page.evaluate("lesson.stage().moment.theta")
    page.evaluate("lesson.goTo('walk', 'bowl')")
    settled(page)
    assert page.evaluate("lesson.stage().moment.E") < 30 and page.evaluate("lesson.stage().steps") == 1
    if how != "skipped":
        assert page.evaluate("lesson.stage().moment.theta") == shown
        page.reload()
        wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
        assert page.evaluate("lesson.stage().moment.theta") == pytest.approx(shown)


SIGNS = "abcdefghjkmnpqrstuvwxyz23456789"  # of a lecturer's code
FIELDS = """() => [...["password", "text", "search", "email", null].map(type =>
    `<input class="typed" ${type ? `type="${type}"` : ""}>`), '<textarea class="typed"></textarea>',
    '<div class="typed" contenteditable>x</div>'].map(html => {
      document.body.insertAdjacentHTML("afterbegin", `<form novalidate>${html}</form>`);
      const form = document.body.firstElementChild;
      form.addEventListener("submit", event => { event.preventDefault(); form.dataset.sent = "1"; });
    })"""
TYPED = "() => [...document.querySelectorAll('.typed')].map(one => one.value ?? one.textContent.slice(1))"


@pytest.mark.parametrize("answers", (0, 4, *(pytest.param(count, marks=pytest.mark.slow) for count in (2, 3))))
def test_what_is_typed_into_a_field_is_the_field_s_own(opened, answers):
    """On the cover, and in steps with so many answers: the keys of the page, such as D, T and 2, do not act."""
    page = opened("choice" if answers else "")
    if answers:
        page.evaluate(
            """count => {
            const {ask} = lesson.data.lessons[0].steps[0], [one] = ask.answers;
            ask.answers = Array.from({length: count}, (_, k) => ({...one, right: !k}));
            lesson.goTo("walk", "place");
            lesson.goTo("walk", "choice");
        }""",
            answers,
        )
    before = at(page)
    page.evaluate(FIELDS)
    for field in page.locator(".typed").all():
        field.focus()
        page.keyboard.press("End")
        page.keyboard.type(SIGNS)
        press(page, "Enter")
    assert {typed.strip() for typed in page.evaluate(TYPED)} == {SIGNS}
    assert page.locator("form[data-sent]").count() == 5
    assert at(page) == before and page.evaluate("document.documentElement.dataset.scheme") == "light"


def test_the_browser_s_back_leads_one_step_back(opened):
    page = opened()
    click(page, "text=Without the questions before it")
    press(page, "2", "Enter", "ArrowRight")
    assert at(page)["step"] == "place"
    page.go_back()
    wait_until(lambda: at(page)["step"] == "choice")
    assert at(page)["revealed"]
    page.go_back()
    wait_until(lambda: at(page)["step"] == "home")
    page.go_forward()
    wait_until(lambda: at(page)["step"] == "choice")


def test_a_slider_changes_no_judgement_after_the_page_was_opened_again(opened):
    page = opened("number")
    page.locator(".ask input").fill("6")
    settled(page)
    click(page, ".primary")
    page.evaluate("lesson.stage().observe(lesson.stage().moment.thetaDemo)")
    press(page, "ArrowRight", "ArrowLeft")
    judged = body(page)
    assert "It is more: 846 px²" in judged
    page.reload()
    wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
    settled(page)
    assert body(page) == judged
