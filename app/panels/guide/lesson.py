"""A lesson, in place of all other panels; and where lessons are begun, the first of which is offered once."""

from viewimit.drawing.svg import escape

from ...control.state import PageState
from ...drawing.links import button, link
from ...lessons.card import draw_lesson
from ...lessons.sliders import draw_sliders
from ..classroom.question import question_html
from ..panel import Layout, Panel
from ..widgets import put_html


class LessonPanel(Panel):
    in_lessons = True

    def build(self, layout: Layout, state: PageState) -> None:
        self._address = layout.address
        self._list = layout.gui.add_html("")
        self._lesson, self._sliders = layout.gui.add_html(""), layout.gui.add_html("")
        self._of: tuple = ()

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._lesson.content

    def depends_on(self, state: PageState) -> tuple:
        course, of_class = state.course, (state.asked, state.holds, state.classroom)
        about = () if course is None else (course.changes, state.message)
        return state.offered, id(course), *about, *of_class

    def show(self, state: PageState) -> None:
        course = state.course
        put_html(self._list, "" if self._address is None else _offers(state, self._address))
        if course is None:
            put_html(self._lesson, "")
            put_html(self._sliders, "")
            return
        below = question_html(state, course, self._address)
        held = state.holds is not None
        put_html(self._lesson, draw_lesson(course, self._address, state.message or "", below, held))
        sliders = draw_sliders(course, self._address)
        of = course.screen, course.given.seed, bool(sliders)
        if of != self._of:  # a slider that is dragged must not be made anew
            self._of = of
            put_html(self._sliders, sliders)


def _offers(state: PageState, address: str) -> str:
    """Links to all lessons, and the offer."""
    links = " · ".join(
        link(address, f"lesson/begin,{name}", f"Lesson: {lesson.title}", escape(lesson.short))
        for name, lesson in state.lessons.items()
    )
    listed = f'<div class="vi-lessons">Lessons: {links}</div>'
    if not state.offered:
        return listed
    name, lesson = next(iter(state.lessons.items()))
    take = button(
        address,
        f"lesson/begin,{name}",
        f"Begin: {lesson.title}",
        '<span class="vi-button vi-filled">Begin <kbd>Enter</kbd></span>',
    )
    no = button(address, "lesson/leave", "Not now", '<span class="vi-button vi-text">Not now <kbd>Esc</kbd></span>')
    words = f"<span><b>New here?</b> {escape(lesson.title)}, {lesson.minutes} min: {escape(lesson.about)}</span>"
    return f'{listed}<div class="vi-offer" role="dialog" aria-label="{escape(lesson.title)}">{words}{take}{no}</div>'
