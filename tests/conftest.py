"""Fixtures: commands run in this process; a Chromium, a page whose errors are kept, a server of one's own.

With VIEWIMIT_REQUIRE_BROWSER=1 a browser test that is skipped, or a run without any that passed, is a failure.
"""

import asyncio
import json
import os
import sys
import threading
from pathlib import Path

if sys.dont_write_bytecode:  # as in many containers, where each process would compile Hypothesis and the tests anew
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # for those that are begun

import browser as chromium
import hypothesis
import pytest
from serving import Server

from viewimit.commands.cli import main
from viewimit.geometry import limit_blas_threads

METHOD = "geometry", "kinematics", "estimation", "servo", "golden"
LONG = "test_site.py", "test_workbench.py", "test_readme.py", "test_extension.py"
WAITING = "test_faults.py", "test_deploy.py"
REQUIRED = os.environ.get("VIEWIMIT_REQUIRE_BROWSER") == "1"
ARM = """<robot name="r"><link name="base"/>
<link name="upper"><visual><geometry><cylinder length="0.4" radius="0.05"/></geometry></visual></link>
<link name="fore"><visual><geometry><box size="0.3 0.06 0.08"/></geometry></visual></link>
<joint name="a" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0 0 0.4" rpy="0.3 0 0"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>"""
passed_in_browser: list[str] = []
limit_blas_threads()  # thread of linear algebra, as commands do; no test has loaded numpy yet
# How long an example takes is the machine's matter; the examples are the same in every run
hypothesis.settings.register_profile("patient", deadline=None, derandomize=True)
hypothesis.settings.load_profile("patient")


@pytest.fixture
def own_arm(tmp_path):
    """The URDF of somebody's arm."""
    path = tmp_path / "someones-folder" / "my-arm.urdf"
    path.parent.mkdir()
    path.write_text(ARM)
    return path


@pytest.fixture
def ask(capsys):
    """Runs a command → exit status, standard output, standard error."""

    def run(*words):
        try:
            status = main([str(word) for word in words])
        except SystemExit as exit:  # argparse
            status = exit.code
        return status, *capsys.readouterr()

    return run


@pytest.fixture
def ask_json(ask):
    def run(*words):
        status, out, _ = ask(*words, "--json")
        assert out.count("\n") == 1
        return status, json.loads(out)

    return run


@pytest.fixture
def event_loop():
    """One that runs in a thread of its own."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    yield loop
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


@pytest.fixture(scope="session")
def chromium_path() -> str:
    """Executable of the browser. Skips without one; `python tests/browser.py` installs it."""
    path = chromium.find()
    if path is None:
        pytest.skip("no Chromium or Chrome; `python tests/browser.py` installs one")
    return path


@pytest.fixture(scope="session")
def browser(chromium_path):
    """One browser for the whole run."""
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=chromium_path, args=chromium.FLAGS)
        yield launched
        launched.close()


@pytest.fixture(scope="session")
def violations():
    """What axe-core finds wrong on a page, a line for each element."""
    axe = pytest.importorskip("axe_playwright_python")
    script = Path(axe.__file__).with_name("axe.min.js").read_text("utf-8")
    found = """async () => (await axe.run(
        {exclude: [".mantine-Progress-root", ".mantine-Notification-closeButton"]}, // viser's, which take no name
        {resultTypes: ["violations"]})).violations.flatMap(({id, nodes}) =>
        nodes.map(node => `${id}: ${node.html.slice(0, 120)}: ${node.failureSummary}`))"""
    return lambda page: (page.evaluate(f"{script};0"), page.evaluate(found))[1]


@pytest.fixture(scope="session")
def server():
    """Address of a `viewimit serve` of its own, stopped at the end as a user would."""
    served = Server()
    yield served.url
    assert served.stop() == 0


def pytest_collection_modifyitems(items):
    """The method first, so that a broken formula shows at once; browsers, which take most of the time, last.

    Between them those that take long or mostly wait, so that no process is left alone with one at the end. Within a
    file the order stays, in which fixtures are set up once.
    """
    in_browser = {item.path for item in items if "browser" in item.keywords}

    def rank(item):
        if item.path.name in (*LONG, *WAITING):
            return 2
        if item.path in in_browser:
            return 3
        return 0 if item.path.parent.name in METHOD else 1

    items.sort(key=rank)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config):
    """With `-n auto`: one more than there are cores, as tests wait for browsers and servers."""
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """With `-n`: a file's tests stay together, in the order above, as pages and studies are shared by file."""
    if config.option.dist != "load":  # another way was asked for
        return None
    from xdist.scheduler import LoadFileScheduling

    config.option.loadscopereorder = False
    return LoadFileScheduling(config, log)


def pytest_runtest_logreport(report):
    if report.when == "call" and report.passed and "browser" in report.keywords:
        passed_in_browser.append(report.nodeid)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    outcome = yield
    report = outcome.get_result()
    if REQUIRED and report.skipped and "browser" in item.keywords:
        report.outcome = "failed"
        report.longrepr = f"a browser test was skipped: {report.longrepr}"


def pytest_sessionfinish(session, exitstatus):
    if REQUIRED and not passed_in_browser:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter):
    if REQUIRED:
        terminalreporter.write_line(f"{len(passed_in_browser)} browser tests passed")
        if not passed_in_browser:
            terminalreporter.write_line("VIEWIMIT_REQUIRE_BROWSER=1, but no browser test ran", red=True)


@pytest.fixture(params=[pytest.param("Firefox", marks=pytest.mark.slow), "Chromium"])
def window(request):
    """A window of 1440x900 px, once in each browser, in which nothing may go wrong."""
    import windows

    if request.param == "Firefox" and windows.find_firefox() is None:
        pytest.skip("no Firefox, or no screen and no Xvfb")
    window = windows.Firefox() if request.param == "Firefox" else windows.Chromium(request.getfixturevalue("browser"))
    yield window
    problems = window.problems
    window.close()
    assert problems == []
