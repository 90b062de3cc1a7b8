"""What a page was before an entry of the glossary was shown: it is given back, whatever has been done since."""

from dataclasses import dataclass, replace

from .editing import UndoableSession
from .past import Left
from .presets import Preset
from .view import CLIENT_REPORTED, View


@dataclass(frozen=True, eq=False)
class BeforeWord:
    """key: of the entry that is shown, by a preset; left: what was there, and playing; past: what had been left behind
    before; view: as it was."""

    key: str
    preset: Preset
    left: Left
    past: tuple[Left, ...]
    view: View
    playing: bool


class ShownWord:
    """Of one page's session."""

    def __init__(self, undoable: UndoableSession):
        self._undoable = undoable
        self._before: BeforeWord | None = None

    @property
    def before(self) -> BeforeWord | None:
        """What was there before the entry that is shown; None if none is."""
        before = self._before
        return before if before is not None and self._undoable.presets.chosen is before.preset else None

    @property
    def key(self) -> str | None:
        """Of the entry that is shown."""
        return None if self.before is None else self.before.key

    def show(self, key: str, preset: Preset, view: View) -> None:
        """Begin with what shows an entry; what was there before the first of them, and its view, is kept."""
        past, playing = self._undoable.past, self._undoable.player.playing
        before = self.before or BeforeWord(key, preset, past.present, past.everything, view, playing)
        self._undoable.begin_preset(preset)
        self._before = replace(before, key=key, preset=preset)

    def give_back(self, view: View) -> View:
        """What was there before, in the window as it is now → as it is to be viewed. Raises ValueError, with all as it
        is, if there is nothing to be given back, or that cannot be any more."""
        before, player = self.before, self._undoable.player
        if before is None:
            raise ValueError("nothing is shown in place of what was here")
        if len(before.left.runs) != len(player.runners):
            raise ValueError("a duel has begun or ended since: end or begin it again first")
        player.pause()
        self._undoable.go_on_with(before.left)
        self._undoable.past.go_back_to(before.past)
        if before.playing:
            player.play()
        return replace(before.view, help=False, **{name: getattr(view, name) for name in CLIENT_REPORTED})
