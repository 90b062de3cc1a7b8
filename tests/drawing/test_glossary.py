"""The glossary: each entry is complete, shown in the help and behind a "?", and what is wrong with one is said."""

from page_fakes import call
from quiet_page import QuietPage
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
