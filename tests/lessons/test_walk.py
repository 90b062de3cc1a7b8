"""A lesson is walked through in Chromium: with the mouse, with keys alone, and with a finger on a phone."""

import pytest
import walking
from browsing import sparing
from waiting import wait_until

pytestmark = pytest.mark.browser

SCREENS = (1280, 720), (820, 1180), (1440, 900), (1920, 1080), (2560, 1440), (390, 844)
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
    contexts, faults, requests = [], [], []

    def open_(step="", seed=4, size=(1280, 720), before=None, **options):
        options = {"reduced_motion": "reduce", **options}
        context = sparing(browser.new_context(viewport={"width": size[0], "height": size[1]}, **options))
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
        page.on("request", lambda request: requests.append(request.url))
        if before:
            page.add_init_script(before)
        page.goto(path.as_uri() + (f"#lesson=walk&step={step}&seed={seed}" if step else ""))
        wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
        settled(page)
        return page

    yield open_
    for context in contexts:
        context.close()
    assert faults == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "about:"))] == []


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


def test_it_begins_with_what_it_is_and_how_long_it_takes(opened):
    page = opened()
    assert "A walk" in body(page) and "6 minutes" in body(page) and "8 questions" in body(page)
    assert "and 4 for each round of 8 questions" in body(page)
    page.evaluate("lesson.data.lessons[0].questions.length = 4; dispatchEvent(new Event('hashchange'))")
    settled(page)
    assert "and 2 for each round of 4 questions" in body(page)
    click(page, "text=Without the questions before it")
    assert at(page)["step"] == "choice"
    assert page.inner_text("#left").endswith("min left")


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


def test_letters_grow_on_a_projector(opened):
    size = "parseFloat(getComputedStyle(document.querySelector('#body .text')).fontSize)"
    sizes = [opened("choice", size=size_).evaluate(size) for size_ in ((1280, 720), (1920, 1080), (2560, 1440))]
    assert sizes[0] >= 15 and sizes[1] > 1.15 * sizes[0] and sizes[2] > 1.15 * sizes[1]


def test_show_me_asks_for_a_guess_first_and_then_shows(opened):
    page = opened("choice")
    click(page, ".primary")
    assert not at(page)["revealed"] and "A guess is enough" in page.inner_text("#note")
    click(page, ".primary")
    assert at(page)["revealed"] and "commit to a guess" in body(page)


def test_show_me_reaches_a_goal_for_who_is_stuck(opened):
    page = opened("servo")
    click(page, ".primary")
    wait_until(lambda: at(page)["revealed"])
    assert page.evaluate("lesson.stage().moment.E") < 30 and "never" not in body(page)


def test_a_counted_task_begins_anew_at_will(opened):
    page = opened("servo")
    steer(page, 0, 10)
    assert "1 step" in body(page)
    click(page, "text=Start again")
    assert "0 steps" in body(page) and len(at(page)["motions"]) == 1 and at(page)["seed"] == 4


def test_what_is_dealt_stands_in_the_address(opened):
    page = opened("servo", seed=2)
    first = page.evaluate("lesson.stage().state.start")
    assert "seed=2" in page.evaluate("location.hash")
    page.evaluate("lesson.reveal()")
    settled(page)
    click(page, "text=Again, from a new start")
    assert "seed=3" in page.evaluate("location.hash") and page.evaluate("lesson.stage().state.start") != first
    assert opened("servo", seed=2).evaluate("lesson.stage().state.start") == first


def test_the_reveal_is_played_unless_motion_is_to_be_reduced(opened):
    page = opened("place", reduced_motion="no-preference")
    mark(page)
    page.click(".primary")
    wait_until(lambda: 0 < at(page)["reveal"] < 1)
    wait_until(lambda: at(page)["reveal"] == 1)
    still = opened("place")
    mark(still)
    still.click(".primary")
    assert at(still)["reveal"] == 1


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


def test_the_questions_can_be_skipped(opened):
    page = opened("before-1")
    click(page, "text=Skip the questions")
    assert at(page)["step"] == "choice"


def test_a_term_explains_itself(opened):
    page = opened("choice")
    click(page, ".term")
    assert page.locator(".definition").is_visible()
    click(page, ".term")
    assert page.locator(".definition").count() == 0


def test_a_screen_reader_hears_what_becomes_known(opened):
    page = opened("choice")
    assert page.locator("h2").evaluate("e => e === document.activeElement")
    press(page, "1", "Enter")
    wait_until(lambda: "No: it is the second." in page.inner_text("#announced"))
    assert "This is one thing to say." in page.inner_text("#announced")
    unnamed = """() => [...document.querySelectorAll('button, input, a, svg[role=img]')].filter(e => e.checkVisibility()
        && !e.getAttribute('aria-label') && !e.textContent.trim() && !e.title).length"""
    for step in STEPS:
        page.evaluate("step => lesson.goTo('walk', step, 4)", step)
        settled(page)
        assert page.evaluate(unnamed) == 0, step


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


def test_a_class_that_is_asked_predicts_in_rounds_and_sees_the_truth_when_it_is_shown(opened):
    page = opened("knobs")
    page.evaluate("window.told = []; lesson.onAnswer = step => told.push(step); lesson.hold(true)")
    settled(page)
    for turn in range(2):
        assert page.inner_text(".primary") == ("Your answer?", "Answered")[turn]
        page.locator(".sliders input").nth(turn).fill("8")
        mark(page, 0.4, 0.4)
        assert page.inner_text(".primary").startswith("Turn")
        press(page, "Enter")
        assert len(at(page)["rounds"]) == turn + 1 and not at(page)["revealed"]
    page.locator(".sliders input").nth(0).fill("8")
    mark(page, 0.4, 0.4)
    assert page.inner_text(".primary") == "Answered" and page.locator(".primary").is_disabled()
    assert page.evaluate("told") == ["knobs", "knobs"]
    page.evaluate("lesson.hold(false); lesson.reveal()")
    settled(page)
    assert at(page)["revealed"] and not at(page)["answer"].get("shown")


def test_a_class_that_is_asked_reaches_a_goal_and_sees_the_truth_when_it_is_shown(opened):
    page = opened("servo")
    page.evaluate("window.told = []; lesson.onAnswer = (...all) => told.push(all); lesson.hold(true)")
    for k, degrees in ((0, 70), (1, -65)):
        steer(page, k, degrees)
    assert page.evaluate("lesson.stage().moment.E") < 30 and not at(page)["revealed"]
    assert page.evaluate("told") == [["servo", {"done": True}, True]] and page.inner_text(".primary") == "Answered"
    page.reload()
    wait_until(lambda: page.evaluate("typeof lesson === 'object'"))
    settled(page)
    assert at(page)["answer"] == {"done": True} and not at(page)["revealed"]
    page.evaluate("lesson.hold(true); lesson.reveal()")
    settled(page)
    assert at(page)["revealed"] and not at(page)["answer"].get("shown")


def test_what_was_put_aside_comes_back_with_its_seed_its_answer_and_its_motions(opened):
    page = opened("servo", seed=3)
    steer(page, 0, 10)
    own = at(page)
    assert own["seed"] == 3 and len(own["motions"]) == 2
    page.evaluate("lesson.suspend(); lesson.goTo('walk', 'servo', 4); lesson.askAgain(); lesson.reveal()")
    settled(page)
    assert at(page)["seed"] == 4 and at(page)["revealed"]
    page.evaluate("lesson.back()")
    settled(page)
    assert at(page) == own
    page.evaluate("lesson.goTo('walk', 'choice'); lesson.goTo('walk', 'servo')")
    settled(page)
    assert at(page) == own


def test_a_page_follows_another_and_goes_back_to_its_own(opened):
    leader, page = opened("place"), opened("choice")
    press(page, "1", "Enter")
    mark(leader, 0.4, 0.6)
    page.evaluate("lesson.suspend()")
    page.evaluate("state => lesson.lead(state)", at(leader))
    settled(page)
    assert (at(page)["step"], at(page)["mark"]) == ("place", at(leader)["mark"])
    leader.click(".primary")
    settled(leader)
    page.evaluate("state => lesson.lead(state)", at(leader))
    settled(page)
    assert at(page)["revealed"]
    page.evaluate("lesson.lead(null); lesson.back()")
    settled(page)
    assert at(page)["step"] == "choice" and at(page)["revealed"] and at(page)["answer"] == {"choice": 0}
    page.evaluate("lesson.goTo('walk', 'place')")
    settled(page)
    assert not at(page)["revealed"] and at(page)["mark"] is None


def test_dark_has_its_own_colours(opened):
    page = opened("choice", color_scheme="dark")
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.keyboard.press("d")
    settled(page)
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != dark


def test_a_glossary_term_is_explained_by_a_key(opened):
    page = opened("choice")
    page.focus(".term")
    press(page, "Enter")
    assert page.locator(".definition").is_visible() and not at(page)["revealed"]


def test_a_step_that_goes_on_from_a_skipped_one_begins_where_that_could_have_ended(opened):
    page = opened("bowl")
    assert page.evaluate("lesson.stage().moment.E") < 30 and page.evaluate("lesson.stage().steps") == 0


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


@pytest.mark.parametrize("answers", (0, 2, 3, 4))
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


def test_show_me_shows_the_step_on_display(opened):
    """After a step was skipped, whose buttons were the same."""
    page = opened("choice")
    click(page, "text=Skip step")
    for _ in range(2):
        click(page, ".primary")
    assert at(page)["step"] == "place" and at(page)["revealed"]


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


def turned(page, slider, share):
    """Drag a slider to a share of its length, and release it."""
    box = page.locator(slider).bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 2, y)
    page.mouse.down()
    page.mouse.move(box["x"] + share * box["width"], y, steps=5)
    settled(page)
    yield
    page.mouse.up()
    page.wait_for_timeout(50)
    settled(page)


def test_a_slider_changes_no_judgement_after_the_answer(opened):
    page = opened("choice")
    press(page, "1", "Enter")
    judged = body(page)
    page.evaluate("lesson.stage().slide('demo 2', -20)")
    settled(page)
    assert body(page) == judged and f"E is {page.evaluate('lesson.stage().moment.E.toFixed(0)')}" not in judged
    page.evaluate("lesson.goTo('walk', 'place')")
    settled(page)
    page.evaluate("lesson.goTo('walk', 'choice')")
    settled(page)
    assert body(page) == judged


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


def test_the_open_questions_are_offered_once_all_steps_are_done(opened):
    page = opened("choice")
    for step in STEPS:
        page.evaluate("step => { lesson.goTo('walk', step, 4); lesson.reveal(); }", step)
        if step == "bet":
            press(page, "ArrowRight")
            page.evaluate("lesson.reveal()")
    page.evaluate("lesson.goTo('walk', 'after-1')")
    settled(page)
    press(page, "1", "s", "Enter", "Escape")
    assert "Go on with the questions" in body(page) and "See the end" in body(page)
    click(page, "text=Go on with the questions")
    assert at(page)["step"] == "after-2"
    press(page, "Escape")
    click(page, "text=See the end")
    assert at(page)["step"] == "end"


def test_the_review_says_what_was_guessed_and_where_each_question_is_answered(opened):
    page = opened("before-1")
    for phase, guessed in (("before", 6), ("after", 1)):
        page.evaluate("phase => lesson.goTo('walk', `${phase}-1`)", phase)
        settled(page)
        for k in range(8):
            press(page, "1", "g" if k < guessed else "s", "Enter")
    assert "Guessed: 6 of 8 → 1 of 8." in body(page)
    rows = page.locator(".review li:not(.heads)")
    shown = [rows.nth(k).locator("> :nth-child(5)").inner_text() for k in range(8)]
    assert "Ray: shadow" in shown and all(shown)
    assert [rows.nth(k).locator("small").all_inner_texts() for k in (0, 7)] == [["guess", "guess"], ["sure", "sure"]]


def test_the_time_left_falls_by_what_is_behind(opened):
    page = opened("before-1")
    minutes = []
    for step in ("before-1", *STEPS, "after-1"):
        page.evaluate("step => lesson.goTo('walk', step, 4)", step)
        settled(page)
        minutes.append(int(page.inner_text("#left").split()[0]))
        page.evaluate("lesson.reveal()")
    assert minutes[0] == 6 + 7 and minutes[-1] == 4
    assert all(0 <= a - b <= 2 for a, b in zip(minutes[1:], minutes[2:]))


def test_a_dragged_slider_gives_its_focus_back_and_one_reached_by_keys_keeps_it(opened):
    page = opened("choice")
    press(page, "1", "Enter")
    for _ in turned(page, ".sliders input", 0.8):
        pass
    value = page.locator(".sliders input").input_value()
    press(page, "ArrowRight")
    assert at(page)["step"] == "place"
    page.evaluate("lesson.goTo('walk', 'choice')")
    settled(page)
    assert page.locator(".sliders input").input_value() == value
    page.focus(".sliders input")
    press(page, "ArrowRight")
    assert at(page)["step"] == "choice" and page.locator(".sliders input").input_value() != value


def test_a_goal_counts_when_the_slider_is_released(opened):
    page = opened("servo")
    page.evaluate("""() => {
        const {ask} = lesson.stage().step;
        ask.counted = false;
        lesson.stage().slide('own 2', -65);
    }""")
    for _ in turned(page, ".sliders input >> nth=0", 70 / 90):
        assert page.evaluate("lesson.stage().moment.E") < 30 and not at(page)["revealed"]
    assert at(page)["revealed"] and at(page)["answer"] == {"done": True}


def test_a_logarithmic_slider_reaches_its_ends(opened):
    page = opened("number")
    page.focus(".ask input")
    press(page, "End")
    assert "2000 px²" in body(page)
    press(page, "Home")
    assert "1 px²" in body(page)


def test_a_slider_of_numbers_counts_its_steps_from_its_low_end(opened):
    page = opened("choice")
    page.evaluate("""() => {
        const {ask} = lesson.data.lessons[0].steps.find(({id}) => id === "number");
        Object.assign(ask, {low: 1, high: 25, step: 2, logarithmic: false});
        lesson.goTo("walk", "number");
    }""")
    settled(page)
    page.locator(".ask input").fill("5")
    settled(page)
    assert at(page)["answer"] == {"number": 5} and "5 px²" in body(page)
    page.focus(".ask input")
    press(page, "ArrowRight", "ArrowRight")
    assert at(page)["answer"] == {"number": 9}
    press(page, "End")
    assert at(page)["answer"] == {"number": 25}


def end_beside_another_lesson(page):
    """The end of the lesson, as if another one were served beside it."""
    page.evaluate("""() => {
        const about = {about: "", minutes: 3, here: false};
        lesson.data.catalogue.push({name: "ray", title: "The shadow of a ray", short: "The ray", ...about});
        lesson.goTo("walk", "after-1");
    }""")
    settled(page)
    press(page, "2", "s")
    page.evaluate("lesson.goTo('walk', 'end')")
    settled(page)
    return page


def test_the_end_names_the_next_lesson_and_links_to_what_is_served_beside_it(opened):
    page = end_beside_another_lesson(opened("choice"))
    assert page.get_attribute("text=Next lesson: The shadow of a ray", "href") == "ray"
    assert page.get_attribute(".review a >> nth=0", "href") == "ray#lesson=ray&step=shadow"


def test_links_to_other_lessons_keep_the_way_back_to_the_page(opened):
    """A page's state has dots, which separate its parts."""
    page = end_beside_another_lesson(opened("choice&page=2.KLUv_Q-A.b"))
    assert page.get_attribute("text=Next lesson: The shadow of a ray", "href") == "ray#page=2.KLUv_Q-A.b"
    assert page.get_attribute(".review a >> nth=0", "href") == "ray#lesson=ray&step=shadow&page=2.KLUv_Q-A.b"
    assert page.evaluate("location.hash").endswith("page=2.KLUv_Q-A.b")


@pytest.mark.parametrize("size", ((1280, 720), (1440, 900)))
def test_neither_head_nor_foot_sticks_out_of_the_card(opened, size):
    page = opened("choice", size=size)
    page.evaluate("lesson.data.lessons[0].short = 'Carry a motion'; lesson.goTo('walk', 'choice', 4)")
    press(page, "1")
    assert (
        page.evaluate("""() => {
        const {right} = document.querySelector(".card").getBoundingClientRect();
        return [...document.querySelectorAll("#foot button, .card > header *")].filter(e => e.checkVisibility()
            && (e.getBoundingClientRect().right > right - 19 || e.tagName === "BUTTON" && e.scrollWidth > e.clientWidth)
        ).map(e => e.textContent);
    }""")
        == []
    )
