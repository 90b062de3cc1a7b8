"""The lecturer's tab: who is here, what each page shows, and what all are to do."""

from collections.abc import Sequence

from viewimit.drawing.classroom.tile import SHAPES, STUCK, Tile, draw_tile
from viewimit.drawing.svg import escape
from viewimit.servo import ServoStatus

from ...classroom.messages import SHADES, Summary
from ...control.classroom.lecturer import SORTS, ClassView
from ...control.state import PageState
from ...drawing.links import button, link, sink
from ..panel import Layout, Panel
from ..widgets import put_html
from .invitation import invitation_html, joining_html

FEW = 12  # tiles that still have room to be large


class LecturerPanel(Panel):
    in_lessons = True

    def build(self, layout: Layout, state: PageState) -> None:
        self._address, self._shared = layout.address, layout.shared
        self._built = state.classroom is not None
        if not self._built:
            return
        self._banner, self._invitation = layout.gui.add_html(""), layout.gui.add_html("")
        with layout.upper_tab("Class"):
            self._head, self._tiles, self._links = (layout.gui.add_html("") for _ in range(3))
            if self._address is not None:
                layout.gui.add_html(sink())

    def depends_on(self, state: PageState) -> tuple:
        return state.classroom, _question_here(state)

    def show(self, state: PageState) -> None:
        view = state.classroom
        if not self._built or view is None:
            return
        names = {name: lesson.short for name, lesson in state.lessons.items()}
        tiles = [tile_of(one, names) for one in view.students]
        put_html(self._banner, _banner(view, _question_here(state), self._address))
        put_html(self._head, _head(view, self._address, self._shared))
        put_html(self._invitation, invitation_html(view, self._address, self._shared))
        few = " vi-tiles-few" if len(tiles) <= FEW else ""
        put_html(self._tiles, f'<div class="vi-tiles{few}">{"".join(map(draw_tile, tiles))}</div>')
        if self._address is not None:
            put_html(self._links, _links(view.students, tiles, self._address, few))


def tile_of(one: Summary, lessons: dict[str, str]) -> Tile:
    """lessons: what they are called, by name."""
    postures = [angle / 10 for angle in one.path]
    plane = None
    if one.plane is not None and one.plane[0] < one.plane[1] and one.plane[2] < one.plane[3]:
        low, high, left, right = (angle / 10 for angle in one.plane)
        plane = (low, high), (left, right)
    note = ""
    if one.lesson is not None:
        name, at, count = one.lesson
        note = f"{lessons.get(name, 'lesson')} {at} of {count}"
    return Tile(
        name=one.name,
        state=one.state,
        E=one.E,
        off=one.off,
        motions=one.motions,
        path=tuple(zip(postures[::2], postures[1::2])),
        demo=None if one.demo is None else (one.demo[0] / 10, one.demo[1] / 10),
        plane=plane,
        hills=(*SHADES, one.hills),
        note=note,
    )


def _question_here(state: PageState) -> bool:
    """Whether the step that is shown is the one that the class is asked: its card says so, and how to go on."""
    asked = None if state.classroom is None else state.classroom.orders.asked
    return asked is not None and state.course is not None and state.course.shows(asked.round.lesson, asked.round.step)


def _banner(view: ClassView, question_here: bool, address: str | None) -> str:
    """Over the scene, while all wait, follow or are locked, or another page of the lecturer's leads."""
    if not view.present:
        return ""
    if not view.leads:
        take = _button(address, "take", "Take over")
        return f'<div class="vi-banner" role="alert"><p><b>Another of your pages leads the class.</b></p>{take}</div>'
    pages, s = ("page", "s") if len(view.students) == 1 else ("pages", "")
    here = f"{len(view.students)} {pages}"
    if view.orders.asked is not None:  # whatever else is ordered: nobody follows meanwhile
        if question_here:
            return ""
        words = f"<b>The class is asked.</b> {here} wait{s} until the question is closed."
        close = _button(address, "close", "Close the question")
        return f'<div class="vi-banner" role="alert"><p>{words}</p>{close}</div>'
    if view.orders.lead is not None:
        return f'<div class="vi-banner" role="alert"><p><b>You lead.</b> {here} follow{s} this one.</p></div>'
    if view.orders.frozen:
        return f'<div class="vi-banner" role="alert"><p><b>Frozen:</b> {here}.</p></div>'
    return ""


def _head(view: ClassView, address: str | None, shared: str | None) -> str:
    counts = (
        (sum(one.state in STUCK for one in view.students), "stuck", SHAPES[ServoStatus.NO_PROGRESS]),
        (
            sum(one.state in (ServoStatus.MOVING, "paused") for one in view.students),
            "on the way",
            SHAPES[ServoStatus.MOVING],
        ),
        (sum(one.state == ServoStatus.READY for one in view.students), "not begun", SHAPES[ServoStatus.READY]),
        (sum(one.state == ServoStatus.SETTLED for one in view.students), "at rest", SHAPES[ServoStatus.SETTLED]),
        (sum(one.state == "arrived" for one in view.students), "there", SHAPES["arrived"]),
    )
    told = "".join(
        f'<span><svg viewBox="0 0 22 22" aria-hidden="true">{shape}</svg>{count} {words}</span>'
        for count, words, shape in counts
        if count
    )
    problem = "" if view.problem is None else f'<p class="vi-class-problem">{escape(view.problem)}</p>'
    joins = joining_html(address, shared)
    first = f'<div class="vi-class-here"><b>{len(view.students)} here</b>{told}</div>{joins}{problem}'
    if address is None:
        return f'<div class="vi-class-head">{first}</div>'
    if not view.leads:
        return f'<div class="vi-class-head">{first}<div>{_button(address, "take", "Take over")}</div></div>'
    leads, frozen = view.orders.lead is not None, view.orders.frozen
    actions = (
        ("send", "Send my state to all", None),
        ("lead", "Let go" if leads else "Lead", leads),
        ("freeze", "Unfreeze" if frozen else "Freeze", frozen),
        ("reset", "Reset all: sure?" if view.sure else "Reset all", None),
    )
    row = "".join(_button(address, verb, words, pressed) for verb, words, pressed in actions)
    sorts = "".join(
        link(address, f"class/sort,{name}", f"Sort by {name}", name, True, view.sort == name) for name in SORTS
    )
    save = _button(address, "save", "Answers as CSV") if view.orders.rounds else ""
    by = f'<div class="vi-class-sort" role="group" aria-label="Sort by">Sort by {sorts}</div>'
    return f'<div class="vi-class-head">{first}<div class="vi-class-actions">{row}{save}</div>{by}</div>'


def _button(address: str | None, verb: str, words: str, pressed: bool | None = None) -> str:
    if address is None:
        return ""
    kind = "vi-class-button" + (" vi-class-on" if pressed else "")
    return button(address, f"class/{verb}", words, f'<span class="{kind}">{words}</span>')


def _links(students: Sequence[Summary], tiles: Sequence[Tile], address: str, few: str) -> str:
    """Over the tiles, and drawn anew only when these are others: what has the focus keeps it."""
    cells = "".join(
        link(
            address, f"class/open,{one.id}", f"{tile.name or 'A student'}: open a copy", '<i class="vi-tile-link"></i>'
        )
        for one, tile in zip(students, tiles)
    )
    return f'<div class="vi-tiles vi-tile-links{few}">{cells}</div>'
