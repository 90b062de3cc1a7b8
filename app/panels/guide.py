"""What explains the page: links to the lab's lessons, the offer of one of them, and the glossary's cards."""

from collections.abc import Mapping
from urllib.parse import quote

import numpy as np

from viewimit.drawing.images.panel import residual_lengths
from viewimit.drawing.svg import escape

from ..drawing.glossary import current_values, linked_cards
from ..drawing.overlays import button
from ..lab.lessons.format import Lesson
from ..lab.lessons.source import ORDER
from ..model.page_model import PageModel
from ..sessions.link import encode_link
from .panel import SLOWEST, Layout, put_html

TOUR = "tour"
REWRITTEN_EVERY = 2.0  # s
LAST = 1e9  # in the order of a column


def lessons(layout: Layout, model: PageModel) -> None:
    """The page's name with Tour, Share and Help; last in its column links to all lessons, each with the way back to
    what the page shows now."""
    head, listed, offered = layout.gui.add_html(""), layout.gui.add_html("", order=LAST), not _offered(model)

    def key(model: PageModel) -> tuple:
        return (
            model.tour_offered,
            model.player.last > 0,
            model.snapshot,
            model.view,
            model.player.speed,
            model.preset.name,
        )

    def draw(model: PageModel) -> None:
        nonlocal offered
        offered = _offered(model)
        put_html(head, draw_head(model, layout.info.lessons))
        put_html(listed, offers(model, layout.info.lessons))

    def period(model: PageModel) -> float:
        """The way back is written anew now and then, as that takes time; the offer goes at once."""
        return REWRITTEN_EVERY if _offered(model) == offered else 0.0

    layout.drawing(key, draw, period)


def glossary(layout: Layout, model: PageModel) -> None:
    """The glossary's cards, unseen until a "?" opens one, and what its numbers are now. Which card is open is the
    browser's own matter."""
    layout.gui.add_html(f'<div class="vi-words">{linked_cards()}</div>')
    values = layout.gui.add_html("")
    layout.drawing(
        lambda model: (model.snapshot, model.word.key),
        lambda model: put_html(values, current_values(numbers_now(model), model.word.key)),
        period=SLOWEST,
    )


def _offered(model: PageModel) -> bool:
    """Whether the tour is: not to a visitor who has begun."""
    return model.tour_offered and model.player.last == 0


def draw_head(model: PageModel, lessons: Mapping[str, Lesson]) -> str:
    """The page's name and three buttons, at every size."""
    first = next(iter(lessons), "")
    tour = TOUR if first in ORDER else first
    buttons = [(f'<a href="lab/{tour}{way_back(model)}">', "Tour", "</a>")] if tour else []
    shown = "".join(f'{start}<span class="vi-head-button">{words}</span>{end}' for start, words, end in buttons)
    for what, words in (("share", "Share"), ("help", "Help")):
        shown += button(f"{what}/0", words, f'<span class="vi-head-button">{words}</span>')
    return f'<div class="vi-title"><b>viewimit</b><nav aria-label="Page">{shown}</nav></div>'


def offers(model: PageModel, lessons: Mapping[str, Lesson]) -> str:
    """Links to all lessons, and the offer of the tour, or of a lecturer's first one."""
    back = way_back(model)
    links = " · ".join(
        f'<a href="lab/{name}{back}" title="{escape(lesson.title)}">{escape(lesson.short)}</a>'
        for name, lesson in lessons.items()
    )
    listed = f'<div class="vi-lessons">Lessons: {links}</div>'
    if not _offered(model) or not lessons:
        return listed
    first = next(iter(lessons))
    name = TOUR if first in ORDER else first  # a lecturer's own come first
    tour = lessons[name]
    take = f'<a href="lab/{name}{back}"><span class="vi-button vi-filled">Begin <kbd>Enter</kbd></span></a>'
    no = button("dismiss/0", "Not now", '<span class="vi-button vi-text">Not now <kbd>Esc</kbd></span>')
    words = f"<span><b>New here?</b> {escape(tour.title)}, {tour.minutes} min: {escape(tour.about)}</span>"
    return f'{listed}<div class="vi-offer" role="dialog" aria-label="{escape(tour.title)}">{words}{take}{no}</div>'


def way_back(model: PageModel) -> str:
    """The address's part by which a lesson knows the page that it is left for; empty where no link holds the page."""
    try:
        return f"#page={quote(encode_link(model.linked()))}"
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
        "points_seen": float(moment.usable.sum()),
        "truth": model.displayed.errors_deg[-1],
    }
