"""How much the lab shows before anything is touched: `python tests/measure_first_view.py` counts controls and words."""

import tempfile
from pathlib import Path

import browser as chromium
from playwright.sync_api import sync_playwright
from viewimit.app.lab.page import lab_page

SIZES = (1440, 900), (390, 844)
COUNT = r"""() => {
  const seen = e => e.checkVisibility({visibilityProperty: true}) && e.offsetWidth > 2;
  const controls = [...document.querySelectorAll("button, input, select, summary")].filter(seen);
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), words = [];
  while (walker.nextNode()) {
    const {textContent, parentElement: e} = walker.currentNode;
    if (e.closest("script, style, select, dialog, noscript, .unseen, #images svg") || !seen(e)) continue;
    words.push(...textContent.split(/\s+/).filter(word => /[A-Za-z]/.test(word)));
  }
  return [controls.map(one => one.id || one.textContent.trim() || one.ariaLabel), words];
}"""


def first_view(page) -> tuple[list[str], list[str]]:
    """Controls and words that an open lab shows, on the whole page."""
    controls, words = page.evaluate(COUNT)
    return controls, words


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium.find(), args=chromium.FLAGS)
        path = Path(folder, "lab.html")
        path.write_text(lab_page(), "utf-8")
        for width, height in SIZES:
            page = browser.new_page(viewport={"width": width, "height": height})
            page.add_init_script("localStorage['viewimit-in-3d'] = 1")  # as with a graphics card
            page.goto(path.as_uri())
            page.locator("#outcome:not(:empty)").wait_for()
            controls, words = first_view(page)
            print(f"{width}x{height}: {len(controls)} controls ({', '.join(controls)}), {len(words)} words")


if __name__ == "__main__":
    main()
