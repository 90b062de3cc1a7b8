"""Preset, its lesson, and the buttons that move the learner."""

from viser import Icon

from ..commands.session import ChoosePreset, Play, Reset, Step, Undo
from ..model.choices import modified
from ..model.queue import Command
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import put, put_html, put_label

MOTIONS: dict[str, Command] = {"Step": Step(), "Undo": Undo(), "Reset": Reset()}


class PlaybackPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue = layout.gui, layout.queue
        self._preset = gui.add_dropdown("Preset", list(state.presets), initial_value=state.preset.name)
        self._more: tuple[str, ...] = ()  # of its options, besides the presets
        queue.on_value(self._preset, ChoosePreset.parse)
        self._lesson = gui.add_html(lesson(state.preset.lesson))
        gui.add_html('<span class="vi-play-row"></span>')
        self._play = gui.add_button("Play", icon=Icon.PLAYER_PLAY)
        queue.on_click(self._play, Play())
        motion = gui.add_button_group("Motion", list(MOTIONS))

        @motion.on_click
        async def _(event) -> None:
            if event.target.value in MOTIONS:
                queue.put(MOTIONS[event.target.value])

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.preset.name, state.modified, state.playing, state.refusals

    def show(self, state: PageState) -> None:
        self._show_preset(state)
        put_html(self._lesson, lesson(state.preset.lesson))
        put_label(self._play, *(("Pause", Icon.PLAYER_PAUSE) if state.playing else ("Play", Icon.PLAYER_PLAY)))

    def _show_preset(self, state: PageState) -> None:
        """One that was changed is an entry of its own, so that the preset itself can be chosen again, and so is one
        that is not of the list."""
        name = modified(state.preset.name) if state.modified else state.preset.name
        more = tuple(shown for shown in dict.fromkeys((state.preset.name, name)) if shown not in state.presets)
        if more != self._more:
            self._more = more
            self._preset.options = (*state.presets, *more)
        put(self._preset, name)


def lesson(text: str) -> str:
    return f'<div class="vi-lesson">{text}</div>'
