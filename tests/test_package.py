"""What is installed: the wheel holds all that runs and metadata that hold on a package index; the documentation."""

import html
import re
import shutil
import subprocess
import sys
import zipfile
from email import message_from_string
from pathlib import Path
from urllib.parse import parse_qsl

import pytest
from viewimit.app.lab.article.page import FIGURES
from viewimit.app.model.link import read_link
from viewimit.app.presets import LAB_PRESETS

import viewimit
from viewimit.commands.cli import COMMANDS, main
from viewimit.drawing.glossary import glossary
from viewimit.loop.codegen import as_python
from viewimit.loop.settings import Settings
from viewimit.simulation.arms import pybullet_has_wheel

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
FOLDERS = {"viewimit": "viewimit", "app": "viewimit/app", "assets": "viewimit/assets"}  # where they install
BESIDE = ("docs", "examples")  # folders that the documentation is made of
FILES = (
    "pyproject.toml", "MANIFEST.in", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff",
)  # fmt: skip


def copied(folder):
    """What a wheel is made of, in a folder that may keep what a build leaves behind."""
    for part in (*FOLDERS, *BESIDE):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    for name in FILES:
        shutil.copy(ROOT / name, folder)
    return folder


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """Built from a copy, so that no build folder is left behind, by what is installed."""
    source, made = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("made")
    copied(source)
    command = [sys.executable, "-m", "pip", "wheel", "-v", "--no-deps", "--no-build-isolation", "--wheel-dir"]
    done = subprocess.run([*command, str(made), str(source)], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Package would be ignored" not in done.stdout and "Deprecat" not in done.stdout, done.stdout
    (path,) = made.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(made / "unpacked")
    return made / "unpacked"


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The documentation, whose examples are executed."""
    pytest.importorskip("sphinx")
    made = tmp_path_factory.mktemp("documentation") / "site"
    done = subprocess.run([sys.executable, ROOT / "docs/build.py", made], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return made


def test_the_wheel_holds_every_file_of_the_package(wheel):
    for folder, inside in FOLDERS.items():
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and path.suffix != ".pyc":
                assert (wheel / inside / path.relative_to(ROOT / folder)).is_file(), path
    assert (wheel / "viewimit/py.typed").is_file()
    assert {path.name.partition("-")[0] for path in wheel.iterdir()} == {"viewimit"}


def test_its_metadata_hold_on_an_index(wheel):
    (path,) = wheel.glob("*.dist-info/METADATA")
    metadata = message_from_string(path.read_text("utf-8"))
    licences = metadata["License-Expression"].split(" AND ")
    assert licences == ["MIT", "Apache-2.0", "BSD-2-Clause", "OFL-1.1"]
    assert len(metadata.get_all("License-File")) == len(licences)
    assert metadata["Version"] == viewimit.__version__
    assert any(name == "Typing :: Typed" for name in metadata.get_all("Classifier"))
    text = metadata.get_payload()
    assert (
        metadata["Description-Content-Type"] == "text/markdown" and "# viewimit\n" in text and "## Two commands" in text
    )


def pages_of(site):
    """Text of each page of the documentation, by its place; replays are pages of their own."""
    pages = sorted(path for path in site.rglob("*.html") if path.parent.name != "gallery")
    return {path.relative_to(site).as_posix(): path.read_text("utf-8") for path in pages}


def test_the_documentation_has_every_page(site):
    pages = pages_of(site)
    written = {
        path.relative_to(ROOT / "docs").with_suffix(".html").as_posix()
        for ending in ("md", "ipynb")
        for path in (ROOT / "docs").rglob(f"*.{ending}")
    }
    assert written <= pages.keys() and len(written) > 15
    assert sum(path.stat().st_size for path in site.rglob("*") if path.is_file()) < 30e6


def test_what_the_documentation_shows_of_examples_was_computed(site, capsys):
    text = {place: html.unescape(re.sub(r"<[^>]+>", "", page)) for place, page in pages_of(site).items()}
    assert main(["imitate", "--demonstrator", "45,-90", "--start", "25,-45"]) == 0
    assert capsys.readouterr().out in text["five-minutes.html"]
    assert "{run-" not in "".join(text.values()) and "`" not in text["reference/library.html"]
    for name in COMMANDS:
        assert f"viewimit {name}" in text["reference/commands.html"]
    for entry in glossary().values():
        assert entry.sentence in text["reference/glossary.html"]
    for figure in tomllib.loads((ROOT / "docs/figures.toml").read_text("utf-8"))["figure"]:
        assert all(command in text["limits.html"] for command in figure["commands"])


def test_its_links_open_the_states_that_are_drawn(site):
    found = {
        (address, float(E))
        for page in pages_of(site).values()
        for E, address in re.findall(r'data-conflict="([^"]+)" href="http://127.0.0.1:8080/\?([^"]+)"', page)
    }
    assert len(found) > 3
    for address, E in found:
        names: dict = {}
        exec(as_python(read_link(html.unescape(address), Settings.paper()).script), names)
        assert names["session"].snapshot.E == pytest.approx(E, rel=1e-9)


def test_all_that_a_page_links_to_or_loads_is_there(site):
    pages = pages_of(site)
    for place, page in pages.items():
        for kind, address in re.findall(r'\b(href|src)="([^"]*)"', page):
            target, _, anchor = html.unescape(address).partition("#")
            if target.startswith(("https:", "http:", "data:")):
                assert kind == "href" or target.startswith("data:"), (place, address)
                continue
            path = (site / place).parent / target.partition("?")[0] if target else site / place
            assert path.is_file(), (place, address)
            if path.name == "lab.html" and "=" in anchor:  # a state of the lab
                assert dict(parse_qsl(anchor))["preset"] in {preset.key for preset in LAB_PRESETS}, (place, address)
            elif anchor and path.suffix == ".html":
                assert f'id="{anchor}"' in path.read_text("utf-8"), (place, address)
        assert not re.search(r'<link[^>]*href="https?:', page) and "@import" not in page
    assert not any(re.search(r"url\(\s*[\"']?https?:", sheet.read_text()) for sheet in site.rglob("*.css"))


@pytest.mark.browser
def test_the_documentation_works_from_a_file_in_a_browser(site, browser):
    begin = (site / "index.html").as_uri()
    context = browser.new_context(viewport={"width": 390, "height": 800}, color_scheme="dark")
    page = context.new_page()
    asked, faults = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    for place in ("limits.html", "reference/commands.html", "notebooks/figures.html", "method.html"):
        page.goto(begin.replace("index.html", place))
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), place
        cut = "[...document.querySelectorAll('pre')].filter(e => e.scrollWidth > e.clientWidth + 1).length"
        assert page.evaluate(cut) == 0, place
    assert page.locator("[data-live] > .still").count() == len(FIGURES)
    page.locator("[data-live]").first.scroll_into_view_if_needed()
    page.locator("[data-live] .live-now input[type=range]").first.wait_for()
    assert page.evaluate("getComputedStyle(document.querySelector('.drawn')).backgroundColor") == "rgb(36, 36, 36)"
    assert page.locator(".equation math").first.bounding_box()["height"] > 12
    page.goto(begin.replace("index.html", "search.html?q=rectification"))
    page.locator("#search-results li a").first.wait_for()
    assert page.locator("#search-results li a[href*='method.html']").count()
    assert all(url.startswith(("file:", "data:")) for url in asked) and not faults, (asked, faults)
    context.close()


def test_the_default_install_has_nothing_that_only_some_can_use():
    """PyBullet and OpenCV are extras; the tests take PyBullet where it has wheels."""
    markers = pytest.importorskip("packaging.markers")
    said = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    project, tests = said["project"], said["dependency-groups"]["test"]
    assert not [need for need in project["dependencies"] if need.startswith(("pybullet", "opencv"))]
    (needed,) = (need for need in tests if "pybullet" in need)
    marker = needed.partition("; ")[2]
    assert markers.Marker(marker).evaluate() == pybullet_has_wheel()
    here = {"python_version": "3.11", "platform_python_implementation": "CPython", "sys_platform": "linux"}
    assert markers.Marker(marker).evaluate(here | {"platform_machine": "x86_64"})
    for other in ({"python_version": "3.12"}, {"sys_platform": "darwin"}, {"platform_machine": "aarch64"}):
        assert not markers.Marker(marker).evaluate(here | {"platform_machine": "x86_64"} | other)
