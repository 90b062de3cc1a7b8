"""The keys of the page, some of them named at the bottom of the left panel; H opens the help: what the page shows."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from string import Template
from typing import Any
from urllib.parse import quote

import numpy as np

from viewimit.drawing.images.panel import residual_lengths
from viewimit.drawing.svg import escape
from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS
from viewimit.wording import listed as and_others

from ..drawing.overlays import button, current_values, linked_cards, listed
from ..lab.lessons.format import Lesson
from ..lab.lessons.source import ORDER
from ..model.keeping import lab_address, lab_lacks, share_link
from ..model.page_model import PageModel
from ..static import STATIC
from ..ways import Ways, about, header
from .panel import SLOWEST, Layout, key_of_link, put_html


@dataclass(frozen=True)
class Key:
    """A key of the page."""

    cap: str  # on the key
    hotkey: Any  # of viser's HotkeyKey
    word: str  # what it does
    sentence: str  # the same, in viser's list of commands
    command: str
    hinted: bool = False  # named in the left panel too


KEYS = (
    Key("space", "space", "play", "Play or pause", "play", True),
    Key("→", "arrowright", "step", "Make one step", "step", True),
    Key("←", "arrowleft", "undo", "Undo one step; at a start, go back to what was before it", "undo"),
    Key("R", "R", "reset", "Reset to the start", "reset"),
    Key("N", "N", "next point", "Choose the next point", "next_point"),
    Key("G", "G", "goal", "Show the goal in L and R, or hide it", "goal"),
    Key("C", "C", "construct", "Build up, step by step, how the chosen point is transferred", "construction"),
    Key("V", "V", "view", "Fit the view", "fit_view"),
    Key("H", "H", "help", "Help", "help", True),
    Key("M", "M", "large", "Pictures large, then figures, then all as before", "next_larger"),
    Key("E", "E", "edit points", "Edit the points of both arms, or end that", "edit_points"),
    Key("B", "B", "best next", "Propose the point that would help most; press again to place it", "best"),
    Key("Del", "delete", "remove point", "Remove the chosen point", "remove"),
    Key("⌫", "backspace", "the same", "Remove the chosen point, by Backspace", "remove"),
    Key("L", "L", "link", "A link to what the page shows, and the code that repeats it", "share"),
    Key("S", "S", "picture", "Save a picture of the panel chosen under Save", "save_picture"),
    Key("Esc", "escape", "close", "Close the help, a large panel or the ghost arm", "dismiss"),
)


def keys(layout: Layout, model: PageModel) -> None:
    layout.gui.add_html(f'<div class="vi-keys">{key_caps(key for key in KEYS if key.hinted)}</div>')
    for key in KEYS:
        _add_hotkey(layout, key)
    layout.modal("viewimit: what is seen here", "help", lambda model: help_html(key_caps(KEYS)))


def _add_hotkey(layout: Layout, key: Key) -> None:
    call = layout.queue.commands[key.command]()
    entry = layout.gui.add_command(key.sentence, hotkey=key.hotkey)

    @entry.on_trigger
    async def put(_event) -> None:
        layout.queue.put(call)


def key_caps(keys: Iterable[Key]) -> str:
    return "".join(f"<span><kbd>{key.cap}</kbd> {key.word}</span> " for key in keys)


HELP_HTML = STATIC.joinpath("help.html").read_text("utf-8")
METHODS = (("Transfers", TRANSFERS), ("Servos", SERVOS))


def help_html(keys: str) -> str:
    """For a modal. keys: what they are, as html."""
    said = lambda one: f"<dt>{one.title}</dt><dd>Assumes: {one.assumes} Fails: {one.limitations}</dd>"
    methods = "".join(
        f"<p><b>{title}</b></p><dl>{''.join(map(said, methods.values()))}</dl>" for title, methods in METHODS
    )
    words = f'<p><b>What the numbers mean</b></p><div class="vi-entries">{listed()}</div>'
    keys = f'<div class="vi-help-keys">{keys}</div>'
    return f'<div class="vi-help">{keys}{HELP_HTML}{methods}{words}{about(Ways())}</div>'


# What explains the page: ways to the lab and its lessons, the offer of one of them, and the glossary's cards.

TOUR = "tour"
PURPOSE = "Your own robot, every method, and experiments. New here, or on a phone? Play is easier."
REWRITTEN_EVERY = 2.0  # s
LAST = 1e9  # in the order of a column


def lessons(layout: Layout, model: PageModel) -> None:
    """The page's name with Share and Help, the ways to lab and lessons in the present state, and the tour's offer."""
    head, offer, offered = layout.gui.add_html(""), layout.gui.add_html("", order=LAST), not _offered(model)
    small = layout.gui.add_html("")

    def draw(model: PageModel) -> None:
        nonlocal offered
        offered = _offered(model)
        put_html(head, draw_head(model, layout.info.lessons))
        put_html(small, draw_small(model))
        put_html(offer, draw_offer(model, layout.info.lessons))

    # the way back is updated now and then, as that takes time; the offer is removed at once
    key = lambda model: (model.player.last > 0, *key_of_link(model))
    layout.drawing(key, draw, lambda model: REWRITTEN_EVERY if _offered(model) == offered else 0.0)


def glossary(layout: Layout, model: PageModel) -> None:
    """The glossary's cards, unseen until a "?" opens one in the browser, and what its numbers are now."""
    layout.gui.add_html(f'<div class="vi-words">{linked_cards()}</div>')
    values = layout.gui.add_html("")
    draw = lambda model: put_html(values, current_values(numbers_now(model)))
    layout.drawing(lambda model: (model.snapshot,), draw, SLOWEST)


def _offered(model: PageModel) -> bool:
    """Whether the tour is offered: not after the first motion."""
    return model.tour_offered and model.player.last == 0


def draw_head(model: PageModel, lessons: Mapping[str, Lesson]) -> str:
    """The page's name and two buttons, at every size; the ways to other pages, and what this one is for."""
    return _head(next(iter(lessons), None)).substitute(play=escape(_lab_of(model)), back=way_back(model))


@cache
def _head(lesson: str | None) -> Template:
    """The head, which has $play and $back for what depends on a page's state."""
    shown = "".join(
        button(f"{what}/0", words, f'<span class="vi-head-button">{words}</span>')
        for what, words in (("share", "Share"), ("help", "Help"))
    )
    ways = Ways("$play", lesson and f"lab/{lesson}$back", workbench="./")
    return Template(
        f'<div class="vi-title"><b role="heading" aria-level="1">viewimit</b><nav aria-label="Page">{shown}</nav></div>'
        f'<div class="vi-purpose">{header(ways, "workbench", with_about=False)}<p>{PURPOSE}</p></div>'
    )


def _lab_of(model: PageModel) -> str:
    return (lab_address(model.snapshot) or "/lab").removeprefix("/")


def draw_small(model: PageModel) -> str:
    """For a window that is too small for the Workbench: the lab in the same state. layout.css shows it."""
    said, lacking = "The lab shows the same on any screen.", lab_lacks(model.snapshot)
    if lacking:
        instead = "the paper's experiment" if lab_address(model.snapshot) is None else "these poses without it"
        said = f"The lab does not have {and_others(lacking)}. It opens with {instead}."
    return (
        '<div class="vi-small" role="dialog" aria-label="A small window"><p>This window is small for the Workbench.'
        f' {escape(said)}</p><a href="{escape(_lab_of(model))}">Open the lab</a>'
        '<button type="button">Open the Workbench anyway</button></div>'
    )


def draw_offer(model: PageModel, lessons: Mapping[str, Lesson]) -> str:
    """The offer of the tour, or of a lecturer's first lesson; "" later."""
    if not _offered(model) or not lessons:
        return ""
    first = next(iter(lessons))
    name = TOUR if first in ORDER else first  # a lecturer's own come first
    tour = lessons[name]
    take = f'<a href="lab/{name}{way_back(model)}"><span class="vi-button vi-filled">Begin <kbd>Enter</kbd></span></a>'
    no = button("dismiss/0", "Not now", '<span class="vi-button vi-text">Not now <kbd>Esc</kbd></span>')
    words = f"<span><b>New here?</b> {escape(tour.title)}, {tour.minutes} min: {escape(tour.about)}</span>"
    return f'<div class="vi-offer" role="dialog" aria-label="{escape(tour.title)}">{words}{take}{no}</div>'


def way_back(model: PageModel) -> str:
    """The address's part by which a lesson knows the page that it is left for; empty where no link holds the page."""
    try:
        return f"#page={quote(share_link(model, hides=True), safe='')}"
    except ValueError:
        return ""


def numbers_now(model: PageModel) -> dict[str, float]:
    """By their keys in the glossary, in the units of their scales; NaN where there is none."""
    moment = model.snapshot
    lengths = residual_lengths(moment)
    known = moment.transfer is not None
    mean = float(lengths.mean()) if known else np.nan
    return {
        "E": moment.E,
        "mean_e": mean,
        "largest_e": float(lengths.max()) / mean if known and mean > 0 else np.nan,
        "condition": float(moment.transfer.condition) if moment.transfer is not None else np.nan,
        "flatness": moment.flatness,
        "points_seen": int(moment.usable.sum()),
        "truth": model.displayed.errors_deg[-1],
    }
