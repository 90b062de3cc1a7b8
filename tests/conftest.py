"""Fixtures: commands run in this process; a Chromium, a page whose errors are kept, a server of one's own.

With VIEWIMIT_REQUIRE_BROWSER=1 a browser test that is skipped, or a run without any that passed, is a failure.
"""

import asyncio
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import browser as chromium
import pytest

from viewimit.cli import main

REQUIRED = os.environ.get("VIEWIMIT_REQUIRE_BROWSER") == "1"
STARTS_WITHIN_S = 30  # on a busy machine
passed_in_browser: list[str] = []
kept_sessions = tempfile.TemporaryDirectory(prefix="viewimit-tests-")  # not the user's own


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


@pytest.fixture
def page(browser):
    """An empty page, 1280 x 720. `page.errors` lists what its console reports as an error and what it throws."""
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    opened = context.new_page()
    opened.errors = []
    opened.on("console", lambda message: message.type == "error" and opened.errors.append(message.text))
    opened.on("pageerror", lambda error: opened.errors.append(str(error)))
    yield opened
    context.close()


@pytest.fixture(scope="session")
def server():
    """Address of a `viewimit serve` of its own, stopped at the end as a user would."""
    process, url = start_server()
    yield url
    assert stop_server(process) == 0


@pytest.fixture(scope="module")
def redis_url(tmp_path_factory):
    """A Redis of one's own, without a port. Skips without redis-server or the package."""
    program = shutil.which("redis-server") or pytest.skip("no redis-server")
    pytest.importorskip("redis")
    socket = tmp_path_factory.mktemp("redis") / "redis.sock"
    command = [program, "--port", "0", "--unixsocket", str(socket), "--save", "", "--appendonly", "no"]
    process = subprocess.Popen([*command, "--dir", str(socket.parent)], stdout=subprocess.DEVNULL)
    until = time.monotonic() + STARTS_WITHIN_S
    while not socket.exists():
        assert process.poll() is None and time.monotonic() < until, "redis-server did not start"
        time.sleep(0.02)
    yield f"unix://{socket}"
    process.terminate()
    process.wait(10)


def start_server(*options: str) -> tuple[subprocess.Popen, str]:
    """A `viewimit serve` on a free port, once it says that it listens."""
    isolated = [sys.executable, "-I"]  # what is installed, not the folder that happens to be the current one
    kept = [] if "--store" in options else ["--store", tempfile.mkdtemp(dir=kept_sessions.name)]
    command = [*isolated, "-m", "viewimit.cli", "serve", "--port", "0", *kept, *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    hung = threading.Timer(STARTS_WITHIN_S, process.kill)
    hung.start()
    said = ""
    for line in process.stdout:
        said += line
        address = re.search(r"http://\S+", line)
        if address:
            hung.cancel()
            threading.Thread(target=process.stdout.read, daemon=True).start()  # so that the pipe never fills
            return process, address.group()
    hung.cancel()
    raise RuntimeError(f"viewimit serve did not start:\n{said}")


def stop_server(process: subprocess.Popen) -> int:
    """Ask it to end, and return its exit status."""
    process.send_signal(signal.SIGTERM)
    try:
        return process.wait(10)
    finally:
        process.kill()


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
