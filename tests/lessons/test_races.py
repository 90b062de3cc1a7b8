"""Servos from the visitor's start: while one looks for something lower than its best, far from there, nobody is told
that it ends so."""

import re
from html import unescape

import numpy as np
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.playing import PLAYED
from walking import course_at

ROW = re.compile(r"<tr[^>]*><td>.*?</svg>([^<]+)</td>" + "<td>([^<]*)</td>" * 5)


def rows(course):
    """By name: motions to the goal, motions made, E and error at the end, why it stopped."""
    return {name: cells for name, *cells in ROW.findall(unescape(draw_lesson(course, "/x")))}


def test_where_a_servo_ends_is_told_once_it_has_ended():
    course = course_at("feel")
    races = {"trust region": 0, "Broyden": 1, "the paper's law": 2}
    farthest = 0.0
    for motion in range(PLAYED):
        shown = rows(course)
        for name, k in races.items():
            moments = course.made["races"][k].moments
            reached, made, E, off, why = shown[name]
            assert made == str(min(motion, len(moments) - 1))
            if motion < len(moments) - 1:
                assert (E, off) == ("…", "…") and why in ("on its way", "looks for anything lower")
                assert reached == "…" or float(reached) <= motion
                continue
            last = moments[-1]
            error = np.degrees(np.abs(last.theta - last.theta_demo).max())
            assert off == f"{error:.1f}°" and E not in ("…", "") and why
            farthest = max(farthest, error)
        course.tick(motion + 1.0)
    course.tick(0.0, still=True)
    assert set(rows(course)) == set(races) and "…" not in str(rows(course)["trust region"])
    assert 0 < farthest < 2  # degrees: of the two that have ended meanwhile
