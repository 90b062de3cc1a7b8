"""The glossary: each entry is complete, shown in the help and behind a "?", and what is wrong with one is said."""

import re

import numpy as np
import pytest
from drawn import SCALE_OF_MORE, parsed
from page_fakes import call
from quiet_page import QuietPage
from viewimit.app.drawing.overlays import asks, beside, current_values, listed
from viewimit.app.panels.guide import help_html, numbers_now

from viewimit.drawing import glossary
from viewimit.drawing.theme import ROLES
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.settings import Settings
from viewimit.loop.simulated_robot import complete

ENTRIES = glossary.glossary()


@pytest.mark.parametrize("key", ENTRIES)
def test_an_entry_has_a_card_and_stands_in_the_help(key):
    card = next(box for box in parsed(glossary.cards()).iter("div") if box.get("id") == f"vi-word-{key}")
    said, helped = "".join(card.itertext()), "".join(parsed(listed()).itertext())
    for words in (ENTRIES[key].name, ENTRIES[key].symbol, ENTRIES[key].sentence, ENTRIES[key].good, ENTRIES[key].bad):
        assert words in said and words in helped
    assert (ENTRIES[key].formula == "") == (card.find(".//{http://www.w3.org/1998/Math/MathML}math") is None)
    assert listed() in help_html("")


@pytest.mark.parametrize("key", ENTRIES)
def test_what_an_entry_shows_can_be_shown_and_undone(key):
    page = QuietPage(Settings())
    page.tick(1.0)
    link = f'data-do="show/{key}"'
    assert link in page.shown and link in help_html("")
    page.act("show", key)
    page.tick(1.0)
    model = page.page.model
    assert not model.modified and model.session.settings == complete(ENTRIES[key].show)
    assert page.widget("Preset").value == f"Show me: {ENTRIES[key].symbol}"
    model.player.scrub(0)
    call("undo").apply(model, page.now)
    assert model.session.settings == complete(Settings()) and model.preset.settings == Settings()


@pytest.mark.parametrize("key", [key for key, entry in ENTRIES.items() if entry.scale is not None])
def test_a_number_that_is_shown_is_a_bad_one(key):
    entry, page = ENTRIES[key], QuietPage(Settings())
    page.act("show", key)
    page.tick(1.0)
    page.tick_until(lambda: not entry.plays or page.page.model.session.snapshot.status.is_at_rest)
    scale, value = entry.scale, numbers_now(page.page.model)[key]
    assert value > scale.bad if scale.good < scale.bad else value < scale.bad


def test_what_a_number_is_now_is_told_at_its_place_on_the_scale():
    assert current_values({"condition": 31.62}) == '<style>#vi-word-condition{--now:50.0%;--words:"now 31.6"}</style>'
    assert "--now:100.0%" in current_values({"E": 1e9}) and "--now:0.0%" in current_values({"E": 0.0})
    assert '"now 8"' in current_values({"points_seen": 8})
    assert current_values({"E": np.nan, "condition": np.inf}) == "<style></style>"
    scale = next(box for box in parsed(glossary.cards()).iter("div") if box.get("class") == SCALE_OF_MORE)
    assert [mark.text for mark in scale.iter("span")] == ["1", "20", "10", "5"]  # of points seen, many are good


def test_every_question_has_its_card():
    for ask in (glossary.ask, beside):
        button = parsed(ask("basin")).find(".//button")
        assert f'id="{button.get("popovertarget")}"' in glossary.cards()
        assert f"#{button.get('popovertarget')}{{position-anchor:" in glossary.cards()
        assert button.get("aria-label") == "What is basin?"
    assert [span.text.strip() for span in parsed(asks(("bias", "rho"))).iter("span")] == ["bias", "ρ"]


def test_the_condition_of_every_transfer_is_explained():
    assert all(glossary.key_of(transfer.condition_name) for transfer in TRANSFERS.values())
    assert glossary.key_of("cond ridge") is None


@pytest.mark.parametrize(
    "text, said",
    [
        ('[E]\nname = "a"\nsymbol = "b"\nshow = {}\n', "entry 'E': Object missing required field `sentence`"),
        ('[E]\nname = "a"\nsymbol = "b"\nsentence = 3\n', r"entry 'E': .*\$\.sentence"),
        ('[E]\nname = "a"\nsymbol = "b"\nsentence = "c"\nshow = {}\nmood = "d"\n', "entry 'E': .*`mood`"),
        (
            '[E]\nname = "a"\nsymbol = "b"\nsentence = "c"\nshow = { noise_px = -1 }\n',
            r"entry 'E': noise_px .*\$\.show",
        ),
        ("[E\n", "glossary.toml: "),
        ("E = 1\n", "glossary.toml: "),
    ],
)
def test_errors_name_entry_and_field(tmp_path, text, said):
    path = tmp_path / "glossary.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=said) as error:
        glossary.load(path)
    assert str(path) in str(error.value)


def test_what_an_entry_leaves_open_is_the_papers(tmp_path):
    path = tmp_path / "glossary.toml"
    path.write_text('[E]\nname = "a"\nsymbol = "b"\nsentence = "c"\nshow = { points = 5, servo = "kalman" }\n')
    assert glossary.load(path)["E"].show == Settings.paper(points=5, servo="kalman")


@pytest.mark.parametrize("ground", ["paper", "card"])
@pytest.mark.parametrize("role", ["ink", "secondary", "recovered", "demonstrator-edge"])
def test_its_type_has_contrast_in_both_schemes(role, ground):
    def luminance(colour):
        channels = [int(pair, 16) / 255 for pair in re.findall("..", colour[1:])]
        r, g, b = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    for colour, behind in zip(ROLES[role], ROLES[ground]):
        low, high = sorted((luminance(colour), luminance(behind)))
        assert (high + 0.05) / (low + 0.05) >= 4.5
