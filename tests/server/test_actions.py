"""Clicks in drawings come by the page's own connection: each once and in order, and nothing else is taken for one."""

from functools import partial

import msgspec
import pytest
from protocol import Client
from serving import Server
from viewimit.app.model.queue import Command, CommandQueue
from viewimit.app.panels.actions import LABEL, MAX_ACTIONS, MAX_CHARS, Actions
from waiting import stays, wait_until


def message(*acts, load="a") -> str:
    return msgspec.json.encode({"load": load, "acts": acts}).decode()


class Taken:
    """What was called, by control."""

    def __init__(self):
        self.values = []
        commands = {
            control: Command(control, lambda model: None, (partial(self._take, control),), link=True)
            for control in ("point", "link")
        }
        self.actions = Actions(CommandQueue({**commands, "seed": Command("seed", lambda model: None)}))

    def _take(self, control: str, value: str) -> None:
        self.values.append((control, value))


def test_each_action_is_taken_once_and_in_order_however_often_it_is_sent():
    taken = Taken()
    taken.actions.take(message((1, "point", "3")))
    taken.actions.take(message((1, "point", "3"), (2, "link", "x")))
    taken.actions.take(message((2, "link", "x"), (3, "point", "4")))
    assert taken.values == [("point", "3"), ("link", "x"), ("point", "4")] and taken.actions.last == 3


class Tab(Client):
    def __init__(self, url: str):
        super().__init__(url)
        self.ready()

    @property
    def chosen(self) -> int | None:
        """The point that its list shows."""
        shown = str(self.value("Point"))
        return int(shown) if shown.isdecimal() else None


@pytest.fixture(scope="module")
def server():
    server = Server()
    yield server
    assert server.stop() == 0


@pytest.fixture
def tab(server):
    with Tab(server.url) as tab:
        yield tab


def test_a_click_reaches_its_page_and_is_acknowledged(tab):
    for chosen in (7, None):
        tab.act("point", 7)
        wait_until(lambda chosen=chosen: tab.chosen == chosen and tab.value(LABEL) == str(tab.acted))


def test_a_value_that_cannot_be_is_refused_on_the_page_as_a_sliders_is(tab):
    tab.act("point", 99)
    wait_until(lambda: "no point 99" in tab.status)
    for value in ("-,.", "nan", "1e999"):
        tab.act("point", value)
        wait_until(lambda value=value: value in tab.status and "is not a number" in tab.status)
    tab.act("nothing")
    wait_until(lambda: "no control 'nothing'" in tab.status.replace("&#x27;", "'"))


REFUSED = {
    "no JSON": "{",
    "no list": '{"load":"a","acts":1}',
    "a number below one": message((0, "point", "1")),
    "a number that is none": message(("1", "point", "1")),
    "a value that is no text": message((1, "point", 1)),
    "a long control": message((1, "p" * 21, "1")),
    "a long value": message((1, "link", "1" * 14_001)),
    "another field": '{"load":"a","acts":[],"more":1}',
    "a long name of the load": message(load="a" * 41),
    "too many": message(*((k + 1, "point", "1") for k in range(MAX_ACTIONS + 1))),
    "too long": " " * MAX_CHARS + message(),
    "deep": "[" * 15_000,
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_no_page_sends_is_refused_with_one_line(server, tab, what):
    with server.says("refused"):
        tab.put(LABEL, REFUSED[what])
    tab.act("point", 2)
    wait_until(lambda: tab.chosen == 2)


def test_a_flood_holds_nobody_else_up(server, tab):
    with Tab(server.url) as bystander:
        for k in range(200):
            tab.act("point", k % 10)
        bystander.act("point", 2)
        wait_until(lambda: bystander.chosen == 2)
        wait_until(lambda: tab.value(LABEL) == str(tab.acted))
        stays(lambda: bystander.chosen == 2, 0.2)
