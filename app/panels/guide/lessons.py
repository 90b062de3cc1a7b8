"""Links to the lab's lessons, and the offer of one of them to somebody who is new here."""

from collections.abc import Mapping
from urllib.parse import quote

from viewimit.drawing.svg import escape

from ...drawing.overlays import button
from ...lab.lessons.format import Lesson
from ...lab.lessons.source import ORDER
from ...model.state import PageState
from ...sessions.link import encode_link
from ..panel import Layout, Panel
from ..widgets import put_html

TOUR = "tour"
REWRITTEN_EVERY = 2.0  # s


class LessonsPanel(Panel):
    """Links to all lessons, each with the way back to what the page shows now."""

    def build(self, layout: Layout, state: PageState) -> None:
        self._lessons, self._offered = layout.lessons, not state.tour_offered
        self._list = layout.gui.add_html("")

    def depends_on(self, state: PageState) -> tuple:
        return state.tour_offered, state.present, state.view, state.speed

    def period(self, state: PageState) -> float:
        """The way back is written anew now and then, as that takes time; the offer goes at once."""
        return REWRITTEN_EVERY if state.tour_offered == self._offered else 0.0

    def show(self, state: PageState) -> None:
        self._offered = state.tour_offered
        put_html(self._list, offers(state, self._lessons))


def offers(state: PageState, lessons: Mapping[str, Lesson]) -> str:
    """Links to all lessons, and the offer of the tour, or of a lecturer's first one."""
    back = way_back(state)
    links = " · ".join(
        f'<a href="lab/{name}{back}" title="{escape(lesson.title)}">{escape(lesson.short)}</a>'
        for name, lesson in lessons.items()
    )
    listed = f'<div class="vi-lessons">Lessons: {links}</div>'
    if not state.tour_offered or not lessons:
        return listed
    first = next(iter(lessons))
    name = TOUR if first in ORDER else first  # a lecturer's own come first
    tour = lessons[name]
    take = f'<a href="lab/{name}{back}"><span class="vi-button vi-filled">Begin <kbd>Enter</kbd></span></a>'
    no = button("dismiss/0", "Not now", '<span class="vi-button vi-text">Not now <kbd>Esc</kbd></span>')
    words = f"<span><b>New here?</b> {escape(tour.title)}, {tour.minutes} min: {escape(tour.about)}</span>"
    return f'{listed}<div class="vi-offer" role="dialog" aria-label="{escape(tour.title)}">{words}{take}{no}</div>'


def way_back(state: PageState) -> str:
    """The address's part by which a lesson knows the page that it is left for; empty where no link holds the page."""
    try:
        return f"#page={quote(encode_link(state.linked()))}"
    except ValueError:
        return ""
