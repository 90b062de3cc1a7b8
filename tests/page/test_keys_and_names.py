"""In a browser: every control has a name, is reached by Tab and can be read, in light and dark. One page for all."""

import re

import pytest
from browsing import (
    HELP,
    POSTURE,
    choose,
    open_page,
    pause,
    posture,
    press,
    row,
    status,
    uncovered_row,
    wait,
    wait_for_count,
    wait_for_status,
)

pytestmark = pytest.mark.browser
TABS = ("Curves", "Equations", "Duel", "Experiments", "Follow", "Landscape")
FOLDERS = ("Start", "Method", "Disturbances", "Actuator errors, random seed", "Points", "Display", "Save")
ROLES = "button|checkbox|combobox|link|radio|slider|spinbutton|switch|tab|textbox"
UNNAMED = re.compile(rf"- (?:{ROLES})\b(?! \")[^\n]*")
# What answers a pointer, and is neither a control that keys reach, nor in one, nor the same as one that they reach
OUT_OF_REACH = """
() => [...document.querySelectorAll("body *:not(canvas)")].filter(e => {
  const style = getComputedStyle(e);
  if (!e.getClientRects().length || style.visibility != "visible" || style.cursor != "pointer") return false;
  const control = e.closest("a,button,input,label,select,textarea,[role]:not([role=group]),[tabindex]");
  return !control || (control.tabIndex < 0 && !control.matches("label,[aria-hidden=true],[role=option]")
    && !control.querySelector("[tabindex='0']"));
}).map(e => e.outerHTML.slice(0, 200))
"""
# Of every text that is seen, against the colours that lie behind it: those with too little contrast
TOO_FAINT = """
() => {
  const canvas = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
  const rgba = colour => {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = colour;
    canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = ([r, g, b, a], under) => [r, g, b].map((c, k) => a * c + (1 - a) * under[k]);
  const luminance = colour => {
    const [r, g, b] = colour.map(c => (c /= 255) <= .03928 ? c / 12.92 : ((c + .055) / 1.055) ** 2.4);
    return .2126 * r + .7152 * g + .0722 * b;
  };
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim(), e = walker.currentNode.parentElement;
    const style = getComputedStyle(e);
    if (!text || !e.getClientRects().length || style.visibility != "visible") continue;
    if (e.closest("style,script,:disabled")) continue;
    const grounds = [];
    let opacity = 1;
    for (let a = e; a; a = a.parentElement) {
      opacity *= getComputedStyle(a).opacity;
      grounds.unshift(rgba(getComputedStyle(a).backgroundColor));
    }
    if (opacity < .05) continue;  // a label that is there for who does not see
    const ground = grounds.reduce((under, colour) => over(colour, under), [255, 255, 255]);
    const ink = rgba(e instanceof SVGElement ? style.fill : style.color);
    const drawn = over([...ink.slice(0, 3), ink[3] * opacity], ground);
    const [low, high] = [luminance(drawn), luminance(ground)].sort((x, y) => x - y);
    const contrast = (high + .05) / (low + .05), needed = parseFloat(style.fontSize) >= 24 ? 3 : 4.5;
    const said = `${text.slice(0, 40)}: ${contrast.toFixed(2)}, ${e.tagName}.${e.getAttribute("class")}`;
    if (contrast < needed) found.push(said);
  }
  return [...new Set(found)];
}
"""


@pytest.fixture(scope="module")
def page(browser, server):
    """With all folders open."""
    page = open_page(browser, server, "small")
    choose(page, "Preset", "The paper's experiment")
    for name in FOLDERS:
        folder = folder_head(page, name)
        folder.press("Enter")
        wait(page, lambda folder=folder: folder.get_attribute("aria-expanded") == "true")
    yield page
    page.close()
    assert page.problems == []


def folder_head(page, name):
    """Its name and, while it is closed, what it holds."""
    return page.get_by_role("button", name=re.compile(f"^{name}(: .*)?$"))


def show(page, tab):
    page.get_by_role("tab", name=tab, exact=True).click()
    pause(page)


def test_every_control_has_a_name_and_is_reached_by_keys(page):
    for tab in TABS:
        show(page, tab)
        assert UNNAMED.findall(page.locator("body").aria_snapshot()) == [], tab
        assert page.evaluate(OUT_OF_REACH) == [], tab


def test_tab_goes_through_the_whole_page(page):
    controls = "input:not(.vi-views *,[type=file]),button:not(:disabled,.mantine-NumberInput-control),[role]"
    page.evaluate("document.activeElement.blur()")
    for _ in range(250):
        page.keyboard.press("Tab")
        seen_before = "(e => e.dataset.reached || (e.dataset.reached = 1) && 0)(document.activeElement)"
        if page.evaluate(seen_before):
            break
    left = """controls => [...document.querySelectorAll(controls)].filter(e => e.checkVisibility() && !e.dataset.reached
      && (!e.role || /button|slider|^tab$/.test(e.role))).map(e => e.outerHTML)"""
    assert page.evaluate(left, controls) == []


def test_arrows_move_the_slider_or_the_tab_that_has_the_focus_and_nothing_else(page):
    press(page, "r")
    wait_for_status(page, "Ready")
    stands = posture(page)
    noise = row(page, "Pixel noise (px)").locator("[role=slider]")
    for key, more in (("ArrowRight", 1), ("ArrowRight", 1), ("ArrowLeft", -1), ("ArrowLeft", -1)):
        before = float(noise.get_attribute("aria-valuenow"))
        noise.press(key)
        pause(page)
        assert more * (float(noise.get_attribute("aria-valuenow")) - before) > 0
    page.get_by_role("tab", name="Landscape", exact=True).press("ArrowRight")
    pause(page)
    assert page.get_by_role("tab", name="Curves", exact=True).get_attribute("aria-selected") == "true"
    assert posture(page) == stands and "Ready" in status(page)
    page.get_by_role("tab", name="Landscape", exact=True).click()
    press(page, "ArrowRight")
    wait(page, lambda: posture(page) != stands)


def test_a_folder_that_has_the_focus_shows_it(page):
    folder = folder_head(page, FOLDERS[0])
    folder.focus()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    assert folder.evaluate("e => e.matches(':focus-visible') && getComputedStyle(e).outlineStyle") == "solid"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_can_be_read(page, scheme):
    page.emulate_media(color_scheme=scheme)
    page.wait_for_selector(f":root[data-mantine-color-scheme={scheme}]")
    for tab in TABS:
        show(page, tab)
        assert (tab, page.evaluate(TOO_FAINT)) == (tab, [])
    page.emulate_media(color_scheme="light")


def test_after_a_choice_in_a_list_the_keys_are_the_pages(page):
    for label, keys in (("Speed", ("ArrowUp", "Enter")), ("Transfer", ("ArrowDown", "Enter"))):
        box = row(page, label).locator("input:visible").first
        box.click()
        for key in keys:
            press(page, key)
        press(page, "Space")
        wait_for_status(page, "Moving|At rest")
        press(page, "Space")
        wait_for_status(page, "Paused|At rest")
        press(page, "r")
        wait_for_status(page, "Ready")
    page.keyboard.press("Tab")
    assert box.evaluate("box => box === document.activeElement")  # Tab goes on from there


def test_after_a_tick_with_the_mouse_the_keys_are_the_pages_and_with_the_keyboard_the_boxs(page):
    show(page, TABS[-1])
    box = page.locator("input[type=checkbox]:visible").first
    for _ in range(2):
        box.click()
        page.wait_for_function("document.activeElement === document.body")
    box.focus()
    for _ in range(2):
        page.keyboard.press("Space")
        assert box.evaluate("box => box === document.activeElement")
    wait_for_status(page, "Ready")
    box.blur()


def test_a_number_box_without_a_number_shows_its_value_again_and_says_its_range(page):
    box = page.get_by_label("Elbow θ₄, −180 … 0", exact=True)
    before = box.input_value()
    for typed in ("", "-"):
        box.fill(typed)
        assert box.get_attribute("placeholder") == "−180 … 0"
        box.blur()
        wait(page, lambda: box.input_value() == before)
    box.fill("7")
    assert box.evaluate("e => e.validationMessage") == "From −180 to 0"
    wait(page, lambda: box.input_value() == before)
    box.blur()
    seed = row(page, "Seed").locator("input")
    seed.fill("")
    seed.blur()
    wait(page, lambda: seed.input_value() == "7")


def test_a_number_box_writes_a_real_minus(page):
    width = """(box, [text, font]) => {
      const pen = document.createElement("canvas").getContext("2d");
      pen.font = `20px ${font || getComputedStyle(box).fontFamily}`;
      return pen.measureText(text).width;
    }"""
    box = page.get_by_label("Elbow θ₄, −180 … 0", exact=True)
    assert box.evaluate(width, ["-", ""]) == box.evaluate(width, ["−", "Inter"]) != box.evaluate(width, ["-", "Inter"])


@pytest.mark.parametrize("size", [(1280, 720), (390, 844)], ids=str)
def test_the_help_closes_by_its_button_which_stays_in_sight_and_by_escape(page, size):
    page.set_viewport_size(dict(zip(("width", "height"), size)))
    page.evaluate("document.activeElement.blur()")
    for closes in (lambda: press(page, "Escape"), lambda: page.get_by_role("button", name="Close", exact=True).click()):
        press(page, "h")
        page.wait_for_selector(HELP)
        page.locator(".vi-entry").last.scroll_into_view_if_needed()
        close = page.get_by_role("button", name="Close", exact=True).bounding_box()
        assert 0 <= close["y"] and close["y"] + close["height"] <= 110 and close["x"] + close["width"] <= size[0]
        closes()
        page.wait_for_selector(HELP, state="detached")
    page.set_viewport_size({"width": 1280, "height": 720})


def test_an_entry_of_the_glossary_shows_itself_and_undo_takes_it_back(page):
    choose(page, "Preset", "Points that get lost")
    wait_for_status(page, "Ready")
    page.locator(".vi-ask[popovertarget=vi-word-points_seen]").click()
    told = lambda: page.locator("#vi-word-points_seen i").first.evaluate("e => getComputedStyle(e, '::before').content")
    wait(page, lambda: re.fullmatch(r'"now \d"', told()))
    before = told()
    page.get_by_role("link", name="Show me a bad one: points seen").click()
    wait(page, lambda: "Show me: points seen" in page.get_by_label("Preset", exact=True).first.input_value())
    wait(page, lambda: told() != before)
    press(page, "Escape")
    wait_for_count(page, ":popover-open", 0, exactly=True)
    press(page, "ArrowLeft")
    wait_for_status(page, "Back is what was here before: Points that get lost")


def test_no_hint_is_seen_while_a_slider_is_dragged(page):
    thumb = uncovered_row(page, "Pixel noise (px)").get_by_role("slider")  # a small window has closed the folders
    box, hint = thumb.bounding_box(), page.locator(".mantine-Tooltip-tooltip")
    page.mouse.move(box["x"] + 3, box["y"] + 4)
    hint.wait_for()
    page.mouse.down()
    page.mouse.move(box["x"] + 40, box["y"] + 4, steps=4)
    wait(page, lambda: float(thumb.get_attribute("aria-valuenow")) > 0)
    assert not any(one.is_visible() for one in hint.all())
    page.mouse.up()


def test_who_asks_for_less_motion_sees_arms_jump_and_folders_open_at_once(page):
    page.emulate_media(reduced_motion="reduce")
    long = "[...document.querySelectorAll('*')].filter(e => parseFloat(getComputedStyle(e).transitionDuration) > .001)"
    moving = "document.getAnimations().filter(a => a.effect.getComputedTiming().duration > 1)"
    wait(page, lambda: page.evaluate(f"[...{long}, ...{moving}].length") == 0)
    press(page, "r")
    wait_for_status(page, "Ready")
    before = posture(page)
    page.evaluate(
        """where => {
      window.postures = [];
      const told = () => window.postures.push([...document.querySelectorAll(where)].map(e => e.textContent).join());
      new MutationObserver(told).observe(document.body, {childList: true, subtree: true});
    }""",
        POSTURE,
    )
    press(page, "ArrowRight")
    wait(page, lambda: posture(page) != before)
    pause(page)
    assert len(set(page.evaluate("window.postures"))) <= 2  # where it was and where it is
    page.emulate_media(reduced_motion="no-preference")
