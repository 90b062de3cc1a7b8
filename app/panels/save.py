"""The folder in which the session is saved as a replay, and panels as pictures."""

import html

from viser import Icon

from ..commands.tools import SavePicture, SaveReplay, choose_format, choose_picture
from ..model.saving import FORMATS, PICTURES, lacking
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import put

REPLAY = "all motions as one file that any browser opens, without a server"
PICTURE = "at print size, in colours of print, with the caption that makes it citable; S"


class SavePanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue = layout.gui, layout.queue
        with gui.add_folder("Save", expand_by_default=False):
            replay = gui.add_button("Save replay", icon=Icon.MOVIE, hint=REPLAY)
            self._what = gui.add_dropdown("Picture", list(PICTURES), initial_value=state.view.picture)
            self._form = gui.add_dropdown("As", list(FORMATS), initial_value=state.view.picture_as)
            picture = gui.add_button("Save picture", icon=Icon.PHOTO_DOWN, hint=PICTURE)
            if why := lacking():
                gui.add_html(f'<div class="vi-why">{html.escape(why)}</div>')
        queue.on_click(replay, SaveReplay())
        queue.on_click(picture, SavePicture())
        queue.on_value(self._what, choose_picture)
        queue.on_value(self._form, choose_format)

    def depends_on(self, state: PageState) -> tuple:
        return state.view.picture, state.view.picture_as, state.refusals

    def show(self, state: PageState) -> None:
        put(self._what, state.view.picture)
        put(self._form, state.view.picture_as)
