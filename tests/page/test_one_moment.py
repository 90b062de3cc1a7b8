"""While an arm is on its way, the strip tells of where the images and the learner's bars show it."""

import re

from page_fakes import call
from quiet_page import QuietPage

from viewimit.loop.settings import Settings


def numbers(page):
    """E of the strip and of the images; the posture of the strip's worst joint and those of the bars; the title."""
    page.tick(0.2)
    shown, strip = page.shown, page.page.layout.named["status"].content
    told = [float(E) for E in re.findall(r"E is ([\d.]+) px²", strip)]
    seen = re.search(r"vi-E.*?<b>([\d.]+)</b>", shown)[1]
    instead = re.search(r" is at (\S+)° but", strip)[1]
    bars = re.findall(r">([−\d.]+)°</b>", shown)
    return told[0], float(seen), instead, bars, re.search(r'role="status"><b>(.*?)</b>', strip)[1]


def test_of_a_step_and_of_one_taken_back():
    page = QuietPage(Settings())
    page.tick(1.0)
    told = []
    for command in (call("step"), call("step"), call("moment", 0)):
        page.page.queue.put(command)
        told += [numbers(page) for _ in range(2)]
        page.tick(1.0)
    for E, seen, instead, bars, title in told:
        assert abs(E - seen) <= 0.051 * max(1.0, E / 100) and instead in bars, (E, seen, instead, bars)
        assert title in ("Moving", "Ready")
    assert len({E for E, *_ in told}) > 3
