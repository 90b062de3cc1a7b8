"""Counts the controls and words of the lab's first view: python tests/measure_first_view.py [PICTURES].

A control is what a pointer or the Tab key can use, whole or in part inside the window; a radio button is one each. A
word has a letter; those of drawings count. PICTURES: a folder for pictures of the views.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import browser as chromium
from playwright.sync_api import Page, sync_playwright
from viewimit.app.lab.page import lab_page
from viewimit.app.ways import Ways

SIZES = {"1440x900": (1440, 900), "390x844": (390, 844)}
SETTLES_MS = 1500
MOST = {"controls": 12, "words": 150}
COUNT = """() => {
  const inside = box => box.width > 1 && box.height > 1 && box.bottom > 0 && box.right > 0
    && box.top < innerHeight && box.left < innerWidth;
  const seen = element => element.checkVisibility({visibilityProperty: true, opacityProperty: true})
    && inside(element.getBoundingClientRect());
  const controls = [...document.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex='0']")]
    .filter(element => !element.disabled && seen(element));
  const words = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), range = new Range();
  while (walker.nextNode()) {
    const {currentNode: node} = walker, parent = node.parentElement;
    if (parent.closest("script, style, noscript, option, .unseen, mask") || !seen(parent)) continue;
    range.selectNodeContents(node);
    if (inside(range.getBoundingClientRect()))
      words.push(...node.textContent.split(/\\s+/).filter(word => /\\p{L}/u.test(word)));
  }
  for (const select of controls.filter(element => element.matches("select")))
    words.push(...select.selectedOptions[0].text.split(/\\s+/));
  return {controls: controls.map(one => one.id || one.getAttribute("aria-label") || one.textContent.trim()), words};
}"""


def count(page: Page) -> dict[str, list[str]]:
    """Return the names of the controls, and the words, that a page shows once all is drawn."""
    page.locator(":is(#space, #still) ~ #fit, #map .vi-now").first.wait_for(state="attached")
    page.wait_for_timeout(SETTLES_MS)
    return page.evaluate(COUNT)


def measure(pictures: Path | None = None) -> dict[str, dict[str, list[str]]]:
    """Return the controls and words of each size, of the lab in a site, which has the most."""
    found = {}
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium.find(), args=chromium.FLAGS)
        path = Path(folder, "lab.html")
        path.write_text(lab_page(ways=Ways.of_site("")), "utf-8")
        for name, (width, height) in SIZES.items():
            page = browser.new_page(
                viewport={"width": width, "height": height}, reduced_motion="reduce", bypass_csp=True
            )
            page.add_init_script("try { localStorage.setItem('viewimit-in-3d', 1); } catch {}")
            page.goto(path.as_uri())
            found[name] = count(page)
            if pictures:
                page.screenshot(path=pictures / f"lab-{name}.png")
            page.close()
    return found


if __name__ == "__main__":
    for size, counts in measure(Path(sys.argv[1]) if len(sys.argv) > 1 else None).items():
        said = "; ".join(f"{len(counts[what])} {what} (at most {most})" for what, most in MOST.items())
        print(f"{size}: {said}\n  {', '.join(counts['controls'])}\n  {' '.join(counts['words'])}")
