"""What the hollow diamonds are is said in the same words wherever they are shown."""

import re
from pathlib import Path

import pytest
from viewimit.app.panels.guide import help_html

from viewimit.drawing.glossary import glossary
from viewimit.drawing.images.panel import write_legend

ROOT = Path(__file__).resolve().parents[2]
TOLD = {
    "help": lambda: help_html(""),
    "glossary": lambda: glossary()["own_views"].sentence,
    "first figure of the documentation": lambda: (ROOT / "docs" / "index.md").read_text("utf-8"),
}


@pytest.mark.parametrize("place", TOLD)
def test_it_says_what_lines_assume_where_they_put_a_point_and_where_dots_and_diamonds_meet(place):
    said = re.sub(r"\s+", " ", TOLD[place]())
    for words in (
        r"as if both arms were in the same pose\b",
        r"[Hh]ollow diamonds? (is|are) where the lines put",
        r"grey ghost",
        r"the goal, which the learner does not know",
        r"only there do dots and diamonds meet",
    ):
        assert re.search(words, said), (place, words)


def test_the_legend_names_the_diamonds_and_the_goal_in_these_words():
    assert "where the lines put it" in write_legend(1, True, True) and ">goal<" in write_legend(1, True, True)
    assert "where the transfer puts it" in write_legend(1, False, False) and "goal<" not in write_legend(
        1, False, False
    )
