"""What the page's style costs a browser: each drawing that comes must leave the style of all else as it is."""

import json
import re
import statistics

import pytest
from browsing import open_page, press, wait_for_status
from viewimit.app.static import stylesheet

OF_THE_ROOT = re.compile(r"(?<![\w-])(?::root|html|body|\.vi-presents)[^\s,{>+~]*:has\(")


def test_no_rule_asks_the_root_what_the_page_holds():
    """A browser would ask anew, and style all of the page anew, whatever comes or goes in it."""
    assert OF_THE_ROOT.search(":root:has(.vi-x) p{color:red}") and OF_THE_ROOT.search(
        ".vi-presents:not(:has(.vi-x)) p{}"
    )
    assert OF_THE_ROOT.findall(stylesheet()) == []


@pytest.mark.browser
def test_while_the_loop_runs_little_of_the_page_is_styled_anew(browser, server):
    page = open_page(browser, server, "small")
    press(page, " ")
    wait_for_status(page, "Moving")
    browser.start_tracing(page=page, categories=["devtools.timeline"])
    page.wait_for_timeout(1500)
    trace = json.loads(browser.stop_tracing())["traceEvents"]
    styled = [event["args"]["elementCount"] for event in trace if "elementCount" in event.get("args", {})]
    elements = page.evaluate("document.querySelectorAll('*').length")
    assert len(styled) > 5 and statistics.median(styled) < elements / 4
    page.close()
    assert page.problems == []
