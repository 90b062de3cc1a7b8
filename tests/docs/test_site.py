"""`viewimit site` writes lab, lessons and documentation: links lead somewhere, what is shown was computed, and a plain
file server serves it below a path."""

import functools
import html
import http.server
import re
import threading
from pathlib import Path
from urllib.parse import parse_qsl

import pytest
from browsing import sparing
from viewimit.app.cli import docs, site
from viewimit.app.lab.article.page import FIGURES
from viewimit.app.presets import LAB_PRESETS

from viewimit.commands.cli import COMMANDS
from viewimit.drawing.glossary import glossary

DOCS = Path(__file__).parents[2] / "docs"
SCRIPT = re.compile(r"<(script|template)\b.*?</\1>", re.S)


@pytest.mark.browser
def test_the_site_is_whole_asks_nobody_and_works_below_a_path(tmp_path, ask, request):
    """One test, so that the documentation is built once, whichever processes the tests run in."""
    pytest.importorskip("sphinx")
    folder = tmp_path / "served" / "x"
    assert ask("site", folder)[0] == 0
    pages = {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in folder.rglob("*.html")}
    sources = [path.relative_to(DOCS) for ending in ("md", "ipynb") for path in DOCS.rglob(f"*.{ending}")]
    written = {f"docs/{path.with_suffix('.html').as_posix()}" for path in sources}
    assert {"index.html", "learn/index.html", *written} <= pages.keys()
    assert sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) < 30e6
    all_is_there(folder, pages)
    examples_were_computed({place: html.unescape(re.sub(r"<[^>]+>", "", page)) for place, page in pages.items()}, ask)
    a_visitor_walks(request.getfixturevalue("browser"), folder)


def all_is_there(folder, pages):
    """What a page links to or loads; nothing is loaded from elsewhere."""
    presets = {preset.key for preset in LAB_PRESETS}
    for place, page in pages.items():
        for kind, address in re.findall(r'\b(href|src)="([^"]*)"', SCRIPT.sub("", page)):
            target, _, anchor = html.unescape(address).partition("#")
            if target.startswith(("https:", "http:", "data:")):
                assert kind == "href" or target.startswith("data:"), (place, address)
                continue
            path = (folder / place).parent / target.partition("?")[0] if target else folder / place
            path = path / "index.html" if path.is_dir() else path
            assert path.is_file(), (place, address)
            if path.resolve() == folder / "index.html":  # a state of the lab
                assert dict(parse_qsl(anchor)).get("preset", "paper") in presets, (place, address)
            elif anchor and path.suffix == ".html":
                assert f'id="{anchor}"' in path.read_text("utf-8"), (place, address)
        assert not re.search(r'<link[^>]*href="https?:', page) and "@import" not in page, place
    assert not any(re.search(r"url\(\s*[\"']?https?:", sheet.read_text("utf-8")) for sheet in folder.rglob("*.css"))


def examples_were_computed(text, ask):
    """Of all pages: text as it is read. The references list what there is."""
    assert ask("imitate", "--demonstrator", "45,-90", "--start", "25,-45")[1] in text["docs/five-minutes.html"]
    assert "{run-" not in "".join(text.values()) and "`" not in text["docs/reference/library.html"]
    assert all(f"viewimit {name}" in text["docs/reference/commands.html"] for name in COMMANDS)
    assert all(entry.sentence in text["docs/reference/glossary.html"] for entry in glossary().values())


def a_visitor_walks(browser, folder):
    handler = functools.partial(QuietHandler, directory=folder.parent)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    begin = f"http://127.0.0.1:{server.server_port}/x/"
    page = sparing(browser.new_context(viewport={"width": 390, "height": 800})).new_page()
    asked, faults = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)

    page.goto(begin)
    page.locator("#play").click()
    page.locator("#day").click()
    page.locator("main.challenge").wait_for()
    for verb in ("learn", "teach", "use", "play"):  # each page leads to the next
        page.locator(f".ways .to-{verb}").locator("visible=true").first.click()
        page.locator(".ways b", has_text=verb.title()).wait_for()
    for place in ("limits", "reference/commands", "notebooks/figures", "method"):
        page.goto(f"{begin}docs/{place}.html")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), place
        cut = "[...document.querySelectorAll('pre')].filter(e => e.scrollWidth > e.clientWidth + 1).length"
        assert page.evaluate(cut) == 0, place
    assert page.locator("[data-live] > .still").count() == len(FIGURES)
    page.locator("[data-live]").first.scroll_into_view_if_needed()
    page.locator("[data-live] .live-now input[type=range]").first.wait_for()
    page.goto(f"{begin}docs/gallery.html")
    page.locator(".gallery a").first.click()
    page.locator("#run").wait_for()
    found = page.locator("#search-results li a")
    from_disk = (folder / "docs").as_uri()
    for where, word in (
        (f"{begin}docs", "servo"),
        (f"{begin}docs", "robot"),
        (from_disk, "cameras"),
        (from_disk, "tracks"),
    ):
        page.goto(f"{where}/search.html?q={word}")
        found.first.wait_for()
        assert found.first.get_attribute("href").startswith(f"how-to/{word}.html")  # how-tos come first
    page.context.close()
    server.shutdown()
    assert not faults
    assert not [url for url in asked if not url.startswith((begin, folder.as_uri(), "data:", "blob:"))]


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *args):
        pass


def test_a_site_replaces_nothing_and_needs_the_sources(tmp_path, ask, monkeypatch):
    (tmp_path / "mine").touch()
    monkeypatch.setattr(site, "find_spec", lambda name: object())
    status, _, said = ask("site", tmp_path)
    assert status == 2 and "is not empty" in said
    monkeypatch.setattr(site, "find_spec", lambda name: None)
    status, _, said = ask("site", tmp_path / "new")
    assert status == 2 and "pip install --group" in said and not (tmp_path / "new").exists()
    monkeypatch.setattr(docs, "CLONE", tmp_path)
    status, _, said = ask("site", tmp_path / "new")
    assert status == 2 and "in a clone of viewimit" in said
