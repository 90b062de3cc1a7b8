"""A class in browsers: a lecturer and five students, one of them on a phone, one whose browser is killed and comes
back, and a server that is killed and begun again midway."""

import csv
import http.server
import io
import threading
from pathlib import Path

import browser as chromium
import pytest
from class_server import CODE, ClassServer
from waiting import wait_until

pytestmark = pytest.mark.browser
LECTURER, STUDENT = {"width": 1280, "height": 720}, {"width": 1000, "height": 700}
PHONE = {"viewport": {"width": 390, "height": 844}, "is_mobile": True, "has_touch": True, "device_scale_factor": 2}
PATIENCE_MS = 60_000
BAR = ".class-bar"
TOKEN = "Object.entries(localStorage).find(([key]) => key.endsWith('token'))[1]"
FLUSHED_MS = 6000  # Chromium writes what pages keep every five seconds


@pytest.fixture(scope="module")
def server():
    with ClassServer("--lesson", "tour", "--lesson", "ray") as server:
        yield server


class Tab:
    """A page of the class in a context of its own, as another device's browser has it."""

    def __init__(self, browser, server, step="eyes", name=None, **how):
        self.context = browser.new_context(**(how or {"viewport": STUDENT}))
        self.context.set_default_timeout(PATIENCE_MS)
        self.server, self.page, self.problems = server, self.context.new_page(), []
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.goto(f"{server.url}/#lesson=tour&step={step}")
        self.page.wait_for_selector(".class-chip.on")
        if name is not None:
            self.page.click(".class-chip")
            self.page.fill("input[maxlength='24']", name)
            self.page.press("input[maxlength='24']", "Tab")
            self.page.click(".class-dialog .close")

    def press(self, words):
        self.page.click(f"{BAR} button:text-is('{words}')")

    def sees(self, words):
        self.page.wait_for_function("words => document.body.innerText.includes(words)", arg=words)

    def at(self, step):
        self.page.wait_for_function("step => lesson.state().step === step", arg=step)

    def wait(self, expression):
        return self.page.wait_for_function(f"() => {expression}")

    def choose(self, k):
        option = self.page.locator(".option").nth(k)
        option.tap() if self.page.evaluate("matchMedia('(pointer: coarse)').matches") else option.click()
        self.sees("Your answer is in")

    def close(self):
        self.context.close()


def logged_in(browser, server, **how):
    tab = Tab(browser, server, **{"viewport": LECTURER, **how})
    if how.get("step") == "home":
        tab.sees("You are in the class.")
        tab.page.click("text=Lecturer: enter the code")
    else:
        tab.page.click(".class-chip")
        tab.page.focus(".class-login input")
    tab.page.keyboard.type(CODE)  # no key of the page acts meanwhile
    tab.page.keyboard.press("Enter")
    tab.page.wait_for_selector(f"{BAR}:not([hidden])")
    return tab


@pytest.mark.parametrize("step", ("home", "before-1", "eyes"))
def test_the_code_is_typed_on_any_screen(browser, server, step):
    tab = logged_in(browser, server, step=step)
    assert tab.page.evaluate("lesson.state().step") == step and not tab.problems
    tab.close()


@pytest.fixture
def lecturer(browser, server):
    tab = logged_in(browser, server)
    yield tab
    assert not tab.problems
    for verb in ("close", "new"):
        tab.page.evaluate("what => classroom.link.send({kind: 'do', what})", verb)
    for verb in ("lead", "frozen", "hidden"):
        tab.page.evaluate("what => classroom.link.send({kind: 'switch', what, on: false})", verb)
    tab.wait("!classroom.orders.asked && !classroom.orders.hidden")
    tab.close()


def test_a_class_of_five_is_asked_twice_with_a_phone_a_killed_browser_and_a_restart(
    browser, chromium_path, server, lecturer, tmp_path
):
    from playwright.sync_api import Error

    mira, ben, aylin = (Tab(browser, server, step="line", name=name) for name in ("Mira", "Ben", None))
    phone = Tab(browser, server, step="line", **PHONE)
    launcher = browser.browser_type
    profile = tmp_path / "profile"
    killed = launcher.launch_persistent_context(profile, executable_path=chromium_path, args=chromium.FLAGS)
    oskar = killed.new_page()
    oskar.goto(f"{server.url}/#lesson=tour&step=line")
    oskar.wait_for_selector(".class-chip.on")
    lecturer.wait("classroom.lecturer.people.size === 5")
    token = oskar.evaluate(TOKEN)

    # first round: four answer, and one browser is killed after its answer
    mira.page.click(".option >> nth=1")  # at its own pace, elsewhere
    lecturer.press("Ask the class")
    for tab, choice in ((mira, 0), (ben, 1), (phone, 1)):
        tab.at("eyes")
        tab.choose(choice)
    oskar.click(".option >> nth=0")
    oskar.wait_for_selector("text=Your answer is in")
    lecturer.sees("4 of 5 answered")
    oskar.wait_for_timeout(FLUSHED_MS)
    for process in processes_of(profile):
        process.kill()
    try:
        killed.close()
    except Error:
        pass
    lecturer.wait("classroom.lecturer.people.size === 4")

    # the server is killed while aylin answers, and comes back
    server.kill()
    aylin.page.wait_for_selector(".class-chip:not(.on)")
    aylin.page.click(".option >> nth=2")
    aylin.sees("1 answer waits here")
    server.lines.clear()
    server.start()
    for tab in (lecturer, mira, ben, phone, aylin):
        tab.page.wait_for_selector(".class-chip.on")
    aylin.sees("Your answer is in")
    again = launcher.launch_persistent_context(profile, executable_path=chromium_path, args=chromium.FLAGS)
    oskar = again.pages[0] if again.pages else again.new_page()
    oskar.goto(server.url)
    oskar.wait_for_function("() => globalThis.lesson?.state().step === 'eyes'")
    lecturer.sees("5 of 5 answered")
    assert oskar.evaluate(TOKEN) == token, "the same person as before"

    # shown here, revealed to all
    assert not mira.page.locator(".class-results").count()
    lecturer.press("Show answers")
    lecturer.sees("2 of 5, 40 %")
    assert "✓" not in lecturer.page.inner_text(".class-dock") and not mira.page.locator(".class-results").count()
    lecturer.press("Reveal")
    for tab in (lecturer, mira, ben, aylin, phone):
        tab.sees("2 of 5 right (40 %)")
        tab.sees("Now you can say")

    # after talking about it, once more
    lecturer.press("Ask again")
    for tab in (mira, ben, aylin, phone):
        tab.sees("what do you say?")
        assert not tab.page.locator(".option.chosen, .option.right").count()
        tab.choose(0)
    lecturer.press("Reveal")
    for tab in (lecturer, phone):
        tab.sees("3 from wrong to right")
    lecturer.press("Close the question")
    for tab in (mira, ben, phone):
        tab.at("line")
    assert mira.page.locator(".option.chosen").count() == 1, "its own answer is back"

    # what was answered, as a table
    lecturer.page.click(f"{BAR} .class-count")
    lecturer.sees("Mira")
    lecturer.page.click(".class-tabs >> text=More")
    with lecturer.page.expect_download() as download:
        lecturer.page.click("text=Answers as CSV")
    rows = list(csv.DictReader(io.StringIO(Path(download.value.path()).read_text())))
    phases = [(row["item"], row["phase"]) for row in rows]
    assert phases.count(("eyes", "round 1")) == 5 and phases.count(("eyes", "round 2")) == 4
    assert phases.count(("line", "own")) == 1 and len({row["person"] for row in rows}) == 5
    again.close()
    for tab in (mira, ben, aylin, phone):
        assert not tab.problems
        tab.close()


def processes_of(profile):
    """The browser's processes, by the folder that they were begun with."""
    psutil = pytest.importorskip("psutil")
    return [
        one for one in psutil.process_iter(["cmdline"]) if f"--user-data-dir={profile}" in (one.info["cmdline"] or ())
    ]


def test_students_follow_the_lecturer_and_have_their_own_back(browser, server, lecturer):
    student = Tab(browser, server, step="line")
    student.page.click(".option >> nth=0")
    lecturer.press("Lead")
    student.sees("The lecturer leads.")
    student.at("eyes")
    lecturer.page.click(".option >> nth=0")
    student.page.wait_for_selector(".option.chosen >> nth=0")
    lecturer.page.click("#foot .primary")
    student.sees("Now you can say")
    slider = lecturer.page.locator("input[type=range]").first
    slider.focus()
    for _ in range(5):
        slider.press("ArrowRight")
    wanted = lecturer.page.evaluate("JSON.stringify(lesson.state().sliders)")
    student.page.wait_for_function("wanted => JSON.stringify(lesson.state().sliders) === wanted", arg=wanted)
    late = Tab(browser, server, step="home")
    late.sees("Now you can say")
    lecturer.press("Release")
    student.at("line")
    assert student.page.locator(".option.chosen").count() == 1 and not student.problems
    for tab in (student, late):
        tab.close()


def test_the_truth_is_hidden_on_all_screens_and_pages_are_frozen_and_gathered(browser, server, lecturer):
    student = Tab(browser, server, step="line")
    lecturer.page.keyboard.press("t")
    student.wait("lesson.stage().truthHidden")
    student.page.keyboard.press("t")
    student.wait("lesson.stage().truthHidden")
    lecturer.press("Freeze")
    student.sees("has frozen this page")
    wait_until(lambda: student.page.locator(".option").first.is_disabled())
    lecturer.press("Ask the class")
    student.choose(0)
    lecturer.press("Close the question")
    student.sees("has frozen this page")
    wait_until(lambda: student.page.locator(".option").first.is_disabled())
    lecturer.press("Unfreeze")
    lecturer.press("Gather here")
    student.at("eyes")
    student.page.keyboard.press("ArrowRight")
    student.page.click("#foot .text")  # on, at its own pace
    student.at("line")
    student.page.reload()
    student.page.wait_for_selector(".class-chip.on")
    student.at("line")
    late = Tab(browser, server, step="home")
    late.at("eyes")
    for tab in (student, late):
        tab.close()


def test_the_eight_questions_are_asked_in_class(browser, server, lecturer):
    student = Tab(browser, server)
    lecturer.page.evaluate("lesson.goTo('tour', 'before-3')")
    lecturer.press("Ask the class")
    student.at("before-3")
    right = "lesson.lessons().find(one => one.name === 'tour').questions[2].answers.find(one => one.right)"
    text = student.page.evaluate(f"{right}.text")
    student.page.click(f".option:has-text('{text}')")
    student.page.click("text=I am guessing")
    student.sees("Your answer is in")
    lecturer.press("Reveal")
    for tab in (student, lecturer):
        tab.sees("1 of 1 right (100 %)")
        tab.sees(student.page.evaluate(f"{right}.because"))
    student.close()


def test_a_class_copies_one_pose_and_the_robot_is_among_the_first(browser, server, lecturer):
    students = [Tab(browser, server, name=name) for name in ("Ann", "Bo")]
    lecturer.press("Challenge")
    for student in students:
        student.page.wait_for_selector(".class-challenge[open] .task:not(:empty)")
    assert len({student.page.inner_text(".class-challenge .task") for student in students}) == 1, "the same for all"
    lecturer.sees("2 still playing, 0 did not find it.")
    find = """async by => {
        const {game, joints} = classroom.challenge.screen, to = game.challenge.demonstrator;
        for (const miss of [.3, 0].slice(by)) {
            joints.target = [to[0], to[1] + miss * (to[1] > -1.5 ? -1 : 1)];
            joints.button.click();
            while (classroom.challenge.screen.isMoving) await new Promise(requestAnimationFrame);
        }
    }"""
    students[0].page.evaluate(find, 1)
    lecturer.sees("1 still playing, 0 did not find it.")
    lecturer.page.click(".class-tabs >> text=Students")
    lecturer.page.wait_for_selector(".class-tile.answered")
    assert (
        "° off" not in lecturer.page.inner_text(".class-tiles")
        and lecturer.page.locator(".class-tile .goal").count() == 0
    )
    lecturer.page.click(".class-tabs >> text=Standings")
    students[1].page.evaluate(find, 0)
    lecturer.sees("0 still playing, 0 did not find it.")
    rows = [row.split() for row in lecturer.page.locator(".class-standings tr").all_inner_texts()]
    assert [row[1] for row in rows] == ["Ann", "Bo", "The"] and [row[0] for row in rows] == ["1", "2", "3"]
    assert [row[-2] for row in rows[:2]] == ["1", "2"] and int(rows[2][-2]) >= 4
    lecturer.page.keyboard.press("Escape")
    lecturer.press("Gather here")
    for student in students:
        student.page.wait_for_selector(".class-challenge:not([open])", state="attached")
        assert not student.problems
        student.close()


class CoursePage(http.server.BaseHTTPRequestHandler):
    """A page of another site that shows the class in a frame."""

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(f'<iframe src="{self.server.framed}"></iframe>'.encode())

    def log_message(self, *_):
        pass


@pytest.mark.parametrize("is_allowed", [True, False])
def test_it_works_in_a_frame_of_an_allowed_site(browser, is_allowed):
    course = http.server.ThreadingHTTPServer(("127.0.0.1", 0), CoursePage)
    threading.Thread(target=course.serve_forever, daemon=True).start()
    site = f"http://localhost:{course.server_port}"  # another one than 127.0.0.1
    embed = site if is_allowed else "https://moodle.example.org"
    with ClassServer("--embed", embed, "--lesson", "tour") as server:
        course.framed = f"{server.url}/"
        page, refused = browser.new_page(), []
        page.on("console", lambda message: refused.append(message.text))
        page.goto(site)
        if is_allowed:
            page.frame_locator("iframe").locator(".class-chip.on").wait_for(timeout=PATIENCE_MS)
        else:
            pause = lambda _: page.wait_for_timeout(50)
            wait_until(lambda: any("frame-ancestors" in text for text in refused), sleep=pause)
        page.close()
    course.shutdown()
    course.server_close()


def test_axe_finds_nothing_in_a_class(browser, server, lecturer, violations):
    phone = Tab(browser, server, **PHONE)
    lecturer.press("Ask the class")
    phone.choose(1)
    assert violations(phone.page) == []
    lecturer.press("Reveal")
    lecturer.press("Large")
    phone.sees("Now you can say")
    assert violations(phone.page) == violations(lecturer.page) == []
    phone.close()
