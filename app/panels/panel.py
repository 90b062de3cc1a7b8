"""How a panel is declared: its widgets with their values and commands, and its drawings with what they depend on.

A panel is a function of a page's `Layout` and model, called once. In it,

- `layout.checkbox("Rays", lambda model: model.view.rays, "switch", "rays")` makes a widget, shows that value whenever
  it changes, and calls the command "switch" with "rays" and the new value when a person changes the widget;
- `layout.drawing(key, draw)` calls `draw(model)` whenever one of the values of `key(model)` has changed.

Nothing is sent when nothing changes.
"""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from viser import ClientHandle, IconName

from ..lab.lessons.format import Lesson
from ..model.choices import joint_name
from ..model.page_model import PageModel
from ..model.queue import CommandQueue
from ..viser_private import push_input, push_property

SLOW, SLOWEST = 0.2, 0.5  # s between two drawings of curves and of numbers, which nobody reads faster
Read = Callable[[PageModel], Any]  # such as lambda model: model.view.rays
Shown = bool | Callable[[PageModel], bool]
Period = float | Callable[[PageModel], float]
Look = tuple[str, IconName | None]  # a button's label and icon


def key_of_link(model: PageModel) -> tuple:
    """Return what a link to a page holds."""
    return model.tour_offered, model.snapshot, model.view, model.player.speed, model.preset.name


class ClientInfo(NamedTuple):
    """How a browser reaches its page. origin: scheme://host:port by which it knows the server, None if it does not say;
    public_url: by which other machines do, None where they cannot; lessons: of the lab, by name."""

    origin: str | None = None
    public_url: str | None = None
    lessons: Mapping[str, Lesson] = {}


@dataclass(eq=False)
class Drawing:
    """A part of a page that is drawn whenever one of the values it depends on has changed. kind: panel and number, the
    same on all pages; tab: in which it stands, "" for none; it is not drawn while that is not open; key: the values
    that it depends on, of snapshots their identity; draw: writes what differs; period: s at least between two drawings,
    0: as often as the page looks for changes at all."""

    kind: Hashable
    tab: str
    key: Callable[[PageModel], tuple]
    draw: Callable[[PageModel], None]
    period: Period = 0.0


@dataclass(eq=False)
class Controls:
    """Widgets of a panel that are brought up to date together: what each shows, and what writes it."""

    queue: CommandQueue
    reads: list[Read] = field(default_factory=list)
    writes: list[tuple[Callable[[Any], None], int | None]] = field(default_factory=list)  # and the widget, if it sends
    skipped: int = 0  # how often one was not written

    def key(self, model: PageModel) -> tuple:
        return model.inputs, self.skipped, *(read(model) for read in self.reads)

    def draw(self, model: PageModel) -> None:
        """Write all but those whose newest value still waits in the queue: their visitor would see an older one."""
        waiting = self.queue.waiting_senders()
        for read, (write, widget) in zip(self.reads, self.writes):
            if widget is not None and widget in waiting:
                self.skipped += 1  # so that all are written once more
            else:
                write(read(model))


class Layout:
    """The widgets and drawings of one page: the left panel, which is `gui` itself, and the right ones with their tabs.
    drawings: those that the panels have declared, in their order; named: widgets that the page must find again."""

    def __init__(self, client: ClientHandle, queue: CommandQueue, info: ClientInfo | None = None):
        self.client, self.gui, self.queue, self.info = client, client.gui, queue, info or ClientInfo()
        self.drawings: list[Drawing] = []
        self.named: dict[str, Any] = {}
        self._panel, self._tab = "", ""  # in which widgets are being declared
        self._controls: dict[tuple[str, str, float], Controls] = {}
        self.gui.main_panel.dock_left()
        self._upper, self._lower = self.gui.add_panel(), self.gui.add_panel()
        self.upper_tabs: dict[str, AbstractContextManager] = {}
        self._lower_tabs: dict[str, AbstractContextManager] = {}

    def build(self, panels: Iterable[Callable[["Layout", PageModel], None]], model: PageModel) -> None:
        """Make all panels, and dock them."""
        self._model = model
        for panel in panels:
            self._panel = panel.__name__
            panel(self, model)
        self._upper.dock_right()
        self._lower.dock_below(self._upper)
        for docked in (self._upper, self._lower):  # on a phone, where panels are sections of one sheet, closed at first
            docked.expand()

    def upper_tab(self, name: str) -> AbstractContextManager[None]:
        """The tab of this name in the upper panel: widgets declared inside stand in it."""
        return self._in_tab(self._upper, self.upper_tabs, name)

    def tab(self, name: str) -> AbstractContextManager[None]:
        """As `upper_tab`, in the lower panel."""
        return self._in_tab(self._lower, self._lower_tabs, name)

    def folder(self, name: str, holds: Read | None = None) -> AbstractContextManager:
        """A closed folder. holds: the choice in it, in a few words, which stands beside its name."""
        label = (lambda model: f"{name}: {holds(model)}") if holds else (lambda model: name)
        handle = self.gui.add_folder(label(self._model), expand_by_default=False)
        if holds:
            self.bind(label, lambda shown: put_properties(handle, label=shown))
        return handle

    @contextmanager
    def row(self, quiet: bool = False) -> Iterator[None]:
        """Widgets that are declared inside stand on one line. quiet: their buttons are less prominent."""
        with self.gui.add_folder(None):
            self.gui.add_html(f'<span class="vi-row{" vi-quiet" if quiet else ""}"></span>')
            yield

    @contextmanager
    def _in_tab(self, panel: Any, made: dict[str, AbstractContextManager], name: str) -> Iterator[None]:
        if name not in made:
            made[name] = panel.add_tab(name)
        before, self._tab = self._tab, name
        with made[name]:
            yield
        self._tab = before

    # Drawings

    def drawing(
        self, key: Callable[[PageModel], tuple], draw: Callable[[PageModel], None], period: Period = 0.0
    ) -> None:
        """Declare a drawing, beside the values that it depends on. The parameters are those of `Drawing`."""
        self.drawings.append(Drawing((self._panel, len(self.drawings)), self._tab, key, draw, period))

    def bind(self, read: Read, write: Callable[[Any], None], widget: Any = None, period: float = 0.0) -> None:
        """Call `write` with a value that is cheap to read, whenever it has changed. widget: that sends it, too."""
        controls = self._controls.get((self._panel, self._tab, period))
        if controls is None:
            controls = self._controls[self._panel, self._tab, period] = Controls(self.queue)
            self.drawing(controls.key, controls.draw, period)
        controls.reads.append(read)
        controls.writes.append((write, None if widget is None else id(widget)))

    # Widgets: what each shows is a constant, or a function of the model

    def html(self, content: str | Read = "", visible: bool | Read = True) -> Any:
        handle = self.gui.add_html(self._first(content), visible=self._first(visible))
        self._bind_if_read(content, lambda shown: put_html(handle, shown))
        return self._seen_if(handle, visible)

    def button(
        self, look: Look | Read, command: str, enabled: Shown = True, visible: Shown = True, **options: Any
    ) -> Any:
        """A button. look: its label and icon; options: of viser's, such as hint."""
        label, icon = self._first(look)
        options |= {"disabled": not self._first(enabled), "visible": self._first(visible)}
        handle = self.gui.add_button(label, icon=icon, **options)
        self.queue.on_click(handle, command)
        self._bind_if_read(look, lambda shown: put_properties(handle, **dict(zip(("label", "icon"), shown))))
        self._bind_if_read(enabled, lambda shown: put_properties(handle, disabled=not shown))
        return self._seen_if(handle, visible)

    def dropdown(
        self, label: str, options: Sequence[str], value: Read, command: str, visible: Shown = True, period: float = 0.0
    ) -> Any:
        shown = self._first(visible)
        handle = self.gui.add_dropdown(label, options, initial_value=value(self._model), visible=shown)
        return self.value(self._seen_if(handle, visible), value, command, period=period)

    def checkbox(
        self, label: str, value: Read, command: str, *first: Any, hint: str | None = None, visible: Shown = True
    ) -> Any:
        handle = self.gui.add_checkbox(label, value(self._model), hint=hint, visible=self._first(visible))
        return self.value(self._seen_if(handle, visible), value, command, *first)

    def slider(
        self, label: str, low: Any, high: Any, step: Any, value: Read, command: str, *first: Any, **options: Any
    ) -> Any:
        period = options.pop("period", 0.0)
        handle = self.gui.add_slider(label, low, high, step, low, **options)
        return self.value(handle, value, command, *first, period=period)

    def modal(self, title: str, field: str, content: Read, key: Read = lambda model: (), period: float = 0.0) -> None:
        """A card over the page. field: of the view, whether it is open, and the name of the command that closes it;
        content: its HTML; key: what that depends on."""
        card: Any = None  # the open one, whose class viser does not name
        inside: Any = None

        def draw(model: PageModel) -> None:
            nonlocal card, inside
            if not getattr(model.view, field):
                if card is not None:
                    card.close()
                card = None
                return
            if card is None:
                card = self.gui.add_modal(title)
                with card:
                    done = self.gui.add_button("Close")  # first, so that it has the focus and is in sight
                    inside = self.gui.add_html("")
                self.queue.on_click(done, field)
            put_html(inside, content(model))

        shown = lambda model: (True, *key(model)) if getattr(model.view, field) else (False,)
        self.drawing(shown, draw, lambda model: period if card is not None and getattr(model.view, field) else 0.0)

    def value(self, handle: Any, value: Read, command: str, *first: Any, period: float = 0.0) -> Any:
        """Bind a widget of any kind: what it shows, and the command that a person's change of it calls."""
        self.queue.on_value(handle, command, *first)
        self.bind(value, lambda shown: put(handle, shown), handle, period)
        return handle

    def _first(self, shown: Any) -> Any:
        """The first value, while the page is built."""
        return shown(self._model) if callable(shown) else shown

    def _bind_if_read(self, shown: Any, write: Callable[[Any], None]) -> None:
        if callable(shown):
            self.bind(shown, write)

    def _seen_if(self, handle: Any, visible: Shown) -> Any:
        self._bind_if_read(visible, lambda shown: put_properties(handle, visible=shown))
        return handle


class JointSliders:
    """One slider for each joint that moves, made again for each world. name: of each, {joint} stands for its joint;
    command: called with the number of the joint, counted among those that move, and its angle in degrees."""

    def __init__(self, layout: Layout, inside: AbstractContextManager, name: str, command: str, hint: str = ""):
        self._layout, self._inside, self._name, self._command, self._hint = layout, inside, name, command, hint or None
        self._sliders: list = []
        self._generation = -1

    def show(self, model: PageModel, angles_deg: Sequence[float]) -> None:
        """angles_deg: (m,)"""
        if model.generation != self._generation:
            self._build(model, angles_deg)
        waiting = self._layout.queue.waiting_senders()
        for slider, angle in zip(self._sliders, angles_deg):
            if id(slider) not in waiting:
                put(slider, round(angle, 1))

    def _build(self, model: PageModel, angles_deg: Sequence[float]) -> None:
        for slider in self._sliders:
            slider.remove()
        scene, self._generation, self._sliders = model.session.scene, model.generation, []
        with self._inside:
            for k, (joint, (low, high)) in enumerate(zip(scene.moving_joints, scene.range_deg)):
                name = self._name.format(joint=joint_name(scene, joint))
                slider = self._layout.gui.add_slider(name, low, high, 0.5, angles_deg[k], hint=self._hint)
                self._layout.queue.on_value(slider, self._command, k)
                self._sliders.append(slider)


def put(handle: Any, value: Any) -> None:
    """Write a value. A slider's own rounding is no change."""
    shown = handle.value
    if not isinstance(shown, (int, float)) or isinstance(shown, bool):
        if shown != value:
            handle.value = value
    elif abs(shown - value) > 1e-9:
        push_input(handle, type(shown)(value))


def put_html(handle: Any, content: str) -> None:
    if handle.content != content:
        push_property(handle, "content", content)


def put_max(slider: Any, value: float) -> None:
    if slider.max != value:
        push_property(slider, "max", value)


def put_properties(handle: Any, **properties: Any) -> None:
    for name, value in properties.items():
        if getattr(handle, name) != value:
            setattr(handle, name, value)
