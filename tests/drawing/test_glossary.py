"""The glossary: each entry is complete, shown in the help and behind a "?", and what is wrong with one is said."""

import pytest
from drawn import parsed
from page_fakes import call
from quiet_page import QuietPage
from viewimit.app.drawing.overlays import asks, beside
from viewimit.app.panels.guide import help_html

from viewimit.drawing import glossary
from viewimit.loop.settings import Settings
from viewimit.loop.simulated_robot import complete

ENTRIES = glossary.glossary()


def test_what_an_entry_shows_can_be_shown_and_undone():
    page = QuietPage(Settings())
    page.tick(1.0)
    model, offered = page.page.model, page.shown
    for key in ENTRIES:
        link = f'data-do="show/{key}"'
        assert link in offered and link in help_html("")
        page.act("show", key)
        page.tick(1.0)
        assert not model.modified and model.session.settings == complete(ENTRIES[key].show), key
        assert page.widget("Preset").value == f"Show me: {ENTRIES[key].symbol}"
        model.player.scrub(0)
        call("undo").apply(model, page.now)
        assert model.session.settings == complete(Settings()) and model.preset.settings == Settings(), key


def test_every_question_has_its_card():
    for ask in (glossary.ask, beside):
        button = parsed(ask("basin")).find(".//button")
        assert f'id="{button.get("popovertarget")}"' in glossary.cards()
        assert f"#{button.get('popovertarget')}{{position-anchor:" in glossary.cards()
        assert button.get("aria-label") == "What is basin?"
    assert [span.text.strip() for span in parsed(asks(("bias", "rho"))).iter("span")] == ["bias", "ρ"]


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
