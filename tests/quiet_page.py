"""A page without a browser: its widgets keep what is written into them, and a test changes them as a person would."""

import contextlib
import time
from types import SimpleNamespace

import drawn
import msgspec
from protocol import Tab
from quiet_client import QuietClient, QuietHandle
from viewimit.app.model.services import Services
from viewimit.app.page.page import Page
from viewimit.app.panels.actions import KEPT_LABEL
from viewimit.app.panels.panel import ClientInfo
from waiting import wait_until

from viewimit.loop.settings import Settings

PERSON = 1  # a client's id


class Widget(QuietHandle):
    def __init__(self, label="", **fields):
        self.callbacks = []
        vars(self).update(fields, label=label)

    def remove(self):
        self.visible = False

    def on_update(self, callback):
        self.callbacks.append(callback)
        return callback

    on_click = on_update


class Gui(QuietHandle):
    """widgets: in the order in which they were added."""

    def __init__(self):
        self.widgets = []

    def _add(self, label, **fields):
        self.widgets.append(Widget(label, **fields))
        return self.widgets[-1]

    def add_html(self, content, visible=True, order=None):
        return self._add("", content=content, visible=visible)

    def add_text(self, label, initial_value, **_):
        return self._add(label, value=initial_value)

    def add_dropdown(self, label, options, initial_value=None, visible=True, **_):
        options = tuple(options)
        return self._add(label, options=options, value=initial_value or options[0], visible=visible)

    def add_slider(self, label, min, max, step, initial_value, hint=None, **_):
        return self._add(label, min=min, max=max, step=step, value=initial_value, hint=hint)

    def add_number(self, label, initial_value, **_):
        return self._add(label, value=initial_value)

    def add_button_group(self, label, options, **_):
        return self._add(label, options=tuple(options), value=options[0])

    def add_checkbox(self, label, initial_value, visible=True, **_):
        return self._add(label, value=initial_value, visible=visible)

    def add_button(self, label, icon=None, disabled=False, visible=True, **_):
        return self._add(label, icon=icon, disabled=disabled, visible=visible)


class QuietPage:
    """Ticked by hand, in a clock of its own."""

    def __init__(self, settings=None, landscapes=None, shared=None, scripts=None, experiments=None, gui=None):
        self.client, self.now, self.acted, self._tab = QuietClient(id(self)), 100.0, 0, Tab()
        self.client.gui = self.gui = gui or Gui()
        given = {"landscapes": landscapes, "experiments": experiments, "scripts": scripts}
        others = {name: service for name, service in given.items() if service is not None}
        services = Services(lambda robot, arm: None, clock=lambda: self.now, **others)
        info = ClientInfo(public_url=shared)
        self.page = Page(self.client, services, settings or Settings.paper(), info)

    def widget(self, label):
        return next(widget for widget in self.gui.widgets if drawn.label(widget.label) == label)

    def choose(self, label, value):
        """Change a widget as a person does: a dropdown offers the value."""
        self.change(label, value)
        self.tick()

    def change(self, label, value):
        """As `choose`; the page has not ticked since."""
        widget = self.widget(label)
        assert value in vars(widget).get("options", (value,)), f"{value} is none of {widget.options}"
        widget.value = value
        self.tell(widget)

    def act(self, control, value):
        """What a link of its drawings asks for, as the page's script sends it."""
        self.acted += 1
        message = {"load": "", "acts": [[self.acted, control, value]]}
        self.page.layout.named["actions"].take(msgspec.json.encode(message).decode())

    def restore(self, text=""):
        """What the tab of an earlier page has kept; "" for a new tab."""
        self.act("session", text)
        self.tick()
        self.tick_until(lambda: not self.page.model.following.goes_on)
        self.settle()

    @property
    def kept(self):
        """What the page's tab has been sent to keep."""
        self.tick(2.0)
        return self._tab.text

    def click(self, label):
        self.tell(self.widget(label))
        self.tick()

    def tell(self, widget):
        for callback in widget.callbacks:
            _finish(callback(SimpleNamespace(client_id=PERSON, target=widget)))

    def tick(self, seconds=0.05):
        """One tick, after that time."""
        self.now += seconds
        self.page.tick(self.now)
        self._tab.take(self.widget(KEPT_LABEL).value)
        self.page.draw()

    def tick_until(self, condition, patience=60.0, seconds=0.5):
        """Tick while threads of the page work. Raises AssertionError after so many seconds of patience."""
        wait_until(condition, patience, lambda pause: (time.sleep(pause), self.tick(seconds)))

    def settle(self):
        """Tick, in no time, until no turn goes on beside the page."""
        self.tick_until(lambda: not self.page.busy, seconds=0.0)

    @property
    def shown(self):
        """All that is written on the page."""
        return "\n".join(widget.content for widget in self.gui.widgets if widget.visible)


def _finish(coroutine):
    """Of a callback, which waits for nothing: no event loop is needed, and one may be running in this thread."""
    with contextlib.suppress(StopIteration):
        coroutine.send(None)
        raise AssertionError("a callback waits")
