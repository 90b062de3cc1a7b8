"""The keys of the page, some of them named at the bottom of the left panel; H opens the help."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

from ...commands.display import BuildUp, FitView, LetGo, NextLarger, NextPoint, ToggleGoal, ToggleHelp, ToggleShare
from ...commands.session import Play, Reset, Step, Undo
from ...commands.tools import BestNext, EditPoints, RemovePoint, SavePicture
from ...model.queue import Command
from ...model.state import PageState
from ..panel import Layout, Panel
from .help import help_html


@dataclass(frozen=True)
class Key:
    """cap: on the key; hotkey: as viser calls it; word: what it does; sentence: in viser's list of commands; hinted:
    named in the left panel, too."""

    cap: str
    hotkey: Literal[
        "space",
        "arrowright",
        "arrowleft",
        "R",
        "N",
        "V",
        "H",
        "G",
        "C",
        "M",
        "E",
        "B",
        "L",
        "S",
        "delete",
        "backspace",
        "escape",
    ]
    word: str
    sentence: str
    command: Command
    hinted: bool = False


KEYS = (
    Key("space", "space", "play", "Play or pause", Play(), True),
    Key("→", "arrowright", "step", "Step: one motion", Step(), True),
    Key("←", "arrowleft", "undo", "Undo: one motion back; at a start, what was before it", Undo()),
    Key("R", "R", "reset", "Reset to the start", Reset()),
    Key("N", "N", "next point", "Choose the next point", NextPoint()),
    Key("G", "G", "goal", "Show the goal in L and R, or hide it", ToggleGoal()),
    Key("C", "C", "construct", "Build up, step by step, how the chosen point is recovered", BuildUp()),
    Key("V", "V", "view", "Fit the view", FitView()),
    Key("H", "H", "help", "Help", ToggleHelp(), True),
    Key("M", "M", "large", "Images large, then figures, then all as before", NextLarger()),
    Key("E", "E", "edit points", "Edit the points of both arms, or end that", EditPoints()),
    Key("B", "B", "best next", "Propose the point that would tell most; once more: place it", BestNext()),
    Key("Del", "delete", "remove point", "Remove the chosen point", RemovePoint()),
    Key("⌫", "backspace", "the same", "Remove the chosen point, by Backspace", RemovePoint()),
    Key("L", "L", "link", "A link to what the page shows, and the code that repeats it", ToggleShare()),
    Key("S", "S", "picture", "Save a picture of the panel chosen under Save", SavePicture()),
    Key("Esc", "escape", "close", "Close the help, or what is large, or let the see-through arm go", LetGo()),
)


class KeysPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._gui, self._queue = layout.gui, layout.queue
        self._help: Any = None  # the open modal, whose class viser does not name
        self._gui.add_html(f'<div class="vi-keys">{key_caps(key for key in KEYS if key.hinted)}</div>')
        for key in KEYS:
            self._add_hotkey(key)

    def depends_on(self, state: PageState) -> tuple:
        return (state.view.help,)

    def show(self, state: PageState) -> None:
        if self._help is not None:
            self._help.close()
            self._help = None
        if state.view.help:
            self._help = self._gui.add_modal("viewimit: what is seen here")
            with self._help:
                done = self._gui.add_button("Close")  # first, so that it has the focus and is in sight
                self._gui.add_html(help_html(key_caps(KEYS)))
            self._queue.on_click(done, ToggleHelp())

    def _add_hotkey(self, key: Key) -> None:
        command = self._gui.add_command(key.sentence, hotkey=key.hotkey)

        @command.on_trigger
        async def _(_event) -> None:
            self._queue.put(key.command)


def key_caps(keys: Iterable[Key]) -> str:
    return "".join(f"<span><kbd>{key.cap}</kbd> {key.word}</span> " for key in keys)
