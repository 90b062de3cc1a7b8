"""What a panel is, and where it finds its place on the page."""

from collections.abc import Hashable, Mapping
from contextlib import AbstractContextManager
from typing import NamedTuple, Protocol

from viser import ClientHandle

from ..lab.lessons.format import Lesson
from ..model.queue import CommandQueue
from ..model.state import PageState

SLOW, SLOWEST = 0.2, 0.5  # s between two drawings of curves and of numbers, which nobody reads faster
WIDTHS = (440, 560, 760)  # px of the right panels, by the room that a window has
LEFT_WIDTHS = (280, 300, 300)


class Reach(NamedTuple):
    """How a browser reaches its page. origin: scheme://host:port by which it knows the server, None if it does not say;
    shared: by which others do, None where they cannot reach it; lessons: of the lab, by name."""

    origin: str | None = None
    shared: str | None = None
    lessons: Mapping[str, Lesson] = {}


NOWHERE = Reach()


class Layout:
    """The left panel, which is `gui` itself, and the right ones with their tabs."""

    def __init__(self, client: ClientHandle, queue: CommandQueue, reach: Reach = NOWHERE):
        self.client, self.gui, self.queue = client, client.gui, queue
        self.origin, self.shared = reach.origin, reach.shared
        self.lessons = reach.lessons
        self.gui.main_panel.dock_left()
        self._upper, self._lower = self.gui.add_panel(), self.gui.add_panel()
        self._upper_tabs: dict[str, AbstractContextManager] = {}
        self._lower_tabs: dict[str, AbstractContextManager] = {}

    def upper_tab(self, name: str) -> AbstractContextManager:
        """The tab of this name in the upper panel, to build in."""
        return _tab(self._upper, self._upper_tabs, name)

    @property
    def upper_tabs(self) -> list[AbstractContextManager]:
        """All that the upper panel has so far."""
        return list(self._upper_tabs.values())

    def tab(self, name: str) -> AbstractContextManager:
        """In the lower one."""
        return _tab(self._lower, self._lower_tabs, name)

    def dock(self) -> None:
        """To be called when all is built."""
        self._upper.dock_right()
        self._lower.dock_below(self._upper)
        self.widen(0)
        for panel in (
            self._upper,
            self._lower,
        ):  # on a phone, where panels are sections of one sheet, that begin closed
            panel.expand()

    def widen(self, room: int) -> None:
        """Give the panels the widths for a window with room for no more, 0, for more, 1, or for much more, 2."""
        self.gui.main_panel.set_width(LEFT_WIDTHS[room])
        self._upper.set_width(WIDTHS[room])


def _tab(panel, made: dict[str, AbstractContextManager], name: str) -> AbstractContextManager:
    if name not in made:
        made[name] = panel.add_tab(name)
    return made[name]


class Panel(Protocol):
    """A part of the page. What a person does with it becomes commands in the layout's queue; what it shows is state.

    inside: the tab in which it stands.
    `build` once, then `show` whenever it is seen and `depends_on` differs from what was shown last.
    """

    inside: str = ""

    def build(self, layout: Layout, state: PageState) -> None:
        """Make the widgets. They need not show the state yet."""
        ...

    def depends_on(self, state: PageState) -> tuple[Hashable, ...]:
        """What it shows; of snapshots their identity counts."""
        ...

    def show(self, state: PageState) -> None:
        """Write what differs."""
        ...

    def seen(self, state: PageState) -> bool:
        """Whether anybody may see it."""
        return self.inside not in state.view.unseen

    def period(self, state: PageState) -> float:
        """s at least between two drawings, longer under load; 0: as often as the page looks for changes at all."""
        return 0.0
