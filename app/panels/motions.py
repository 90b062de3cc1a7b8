"""The tab Motions: record the demonstrator's motion, replay it, go through it, keep it in a file."""

from html import escape

from viser import Icon

from viewimit.drawing.theme import rgb

from ..commands.tools import ChooseMotion, LoadMotion, Record, Replay, SaveMotion, ShowMoment
from ..model.motions import NAMES
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import put, put_html, put_label, put_most

ABOUT = (
    '<div class="vi-about">A motion of the demonstrator: drawn about its present posture, recorded while you move it,'
    " or loaded from a file. Play follows it with the learner; Fig. 10 under Experiments imitates it.</div>"
)


class MotionsPanel(Panel):
    inside = "Motions"

    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue = layout.gui, layout.queue
        with layout.tab(self.inside):
            gui.add_html(ABOUT)
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row"></span>')
                self._motion = gui.add_dropdown("Chosen motion", list(NAMES.values()))
                self._record = gui.add_button("Record", icon=Icon.PLAYER_RECORD, color=rgb("stopped"))
                self._replay = gui.add_button("Replay", icon=Icon.PLAYER_PLAY)
            self._moment = gui.add_slider("Time s", 0.0, 1.0, 0.05, 0.0, hint="of the chosen motion")
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row"></span>')
                self._said = gui.add_html("")
                save = gui.add_button("Save", icon=Icon.DOWNLOAD)
                load = gui.add_upload_button("Load", icon=Icon.UPLOAD, mime_type="application/json")
        queue.on_value(self._motion, ChooseMotion.parse)
        queue.on_value(self._moment, ShowMoment.parse)
        queue.on_click(self._record, Record())
        queue.on_click(self._replay, Replay())
        queue.on_click(save, SaveMotion())

        @load.on_upload
        async def _(event) -> None:
            queue.put(LoadMotion.parse(event.target.value.content))

    def depends_on(self, state: PageState) -> tuple:
        motions = state.motions
        said = motions.name, motions.moment, motions.recording, motions.replaying, motions.describe()
        return state.generation, *said, state.refusals

    def show(self, state: PageState) -> None:
        motions = state.motions
        put(self._motion, NAMES[motions.name])
        put_label(self._record, *(("Stop", Icon.PLAYER_STOP) if motions.recording else ("Record", Icon.PLAYER_RECORD)))
        put_label(self._replay, *(("Stop", Icon.PLAYER_STOP) if motions.replaying else ("Replay", Icon.PLAYER_PLAY)))
        seconds, last = motions.moment
        if self._moment.step != motions.step_s:
            self._moment.step = motions.step_s
        put_most(self._moment, last)
        put(self._moment, seconds)
        kind, sentence = motions.describe()
        put_html(self._said, f'<div class="vi-said">{escape(sentence) if kind == "ready" else ""}</div>')
