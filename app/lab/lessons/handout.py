"""A lesson on paper: each step with its picture, its question to answer by hand, and, for the lecturer, the solutions.

Numbers that the library has computed stand in the texts. A measure that only a browser computes is a blank to fill in.
"""

import re
from collections.abc import Iterable
from math import floor, log, log10
from typing import Literal, overload

from . import facts
from .format import (
    Bet,
    Choice,
    Do,
    Figure,
    Lesson,
    Number,
    Option,
    Place,
    Pose,
    Predict,
    Step,
    measures_of,
)
from .paper_measures import PAPER_MEASURES
from .paper_pictures import Frame, image, outside, posture_map, ruler
from .sheet import (
    GREY,
    HEIGHT,
    INK,
    MARGIN,
    PALE,
    WIDTH,
    Canvas,
    HtmlCanvas,
    PdfCanvas,
    text_width,
    write,
)
from .situation import Situation
from .step_data import sampled_situations, situation_of

BLANK = "_____"
FIRST_START = "This is start 1. On the screen, it is the one with &seed=1 at the end of the address."
OUTSIDE = ("outside", "room from above")
DRAWN = ("l", "r", "L", "R", "landscape", *OUTSIDE)
BODY, SMALL, TITLE = 9.5, 8.0, 14.0  # pt
GAP, PICTURES = 7.0, 84.0  # mm: between both columns; width of the pictures' column
TEXT_LEFT, TEXT_WIDTH = MARGIN + PICTURES + GAP, WIDTH - 2 * MARGIN - PICTURES - GAP
IMAGE_HEIGHT, SMALL_HEIGHT = 57.0, 33.0
LINE_STEP = 7.5  # mm between lines to write on
MAX_SMALL = 2
Box = tuple[float, float, float, float]


@overload
def handout(lesson: Lesson, kind: Literal["html"], solutions: bool = False) -> str: ...
@overload
def handout(lesson: Lesson, kind: Literal["pdf"], solutions: bool = False) -> bytes: ...
def handout(lesson: Lesson, kind: Literal["html", "pdf"], solutions: bool = False) -> str | bytes:
    """Return a lesson as pages to print.

    Parameters
    ----------
    lesson
        The lesson.
    kind
        HTML with one drawing a page, or PDF.
    solutions
        With answers, replies and revealed pictures instead of room to write.

    Raises
    ------
    ModuleNotFoundError
        For PDF without fpdf2.
    """
    canvas = HtmlCanvas() if kind == "html" else PdfCanvas()
    pages = _Pages(canvas, lesson, solutions)
    for number, step in enumerate(lesson.step, 1):
        pages.add(number, step)
    return canvas.finish(f"{lesson.title}{', solutions' if solutions else ''} · viewimit")


class _Pages:
    """Where the next step goes: on the page, or on a new one if it does not fit."""

    def __init__(self, canvas: Canvas, lesson: Lesson, solutions: bool):
        self._canvas, self._lesson, self._solutions = canvas, lesson, solutions
        self._page, self._bottom = 0, HEIGHT

    def add(self, number: int, step: Step) -> None:
        sheet = _StepOnPaper(self._lesson, step, self._solutions)
        heading = f"{number}  {step.title}"
        height = sheet.draw(_Nowhere(), heading, 0.0)
        if self._bottom + height > HEIGHT - MARGIN or self._page == 0:
            self._begin_page()
        sheet.draw(self._canvas, heading, self._bottom)
        self._bottom += height + 6.0

    def _begin_page(self) -> None:
        self._page += 1
        self._canvas.page()
        solved = ", solutions" if self._solutions else ""
        self._canvas.text(
            (MARGIN, 12.0), f"viewimit · {self._lesson.title}{solved} · page {self._page}", SMALL, colour=GREY
        )
        if not self._solutions:
            name = "Name or number: ______________________"
            self._canvas.text((WIDTH - MARGIN - text_width(name, SMALL), 12.0), name, SMALL, colour=GREY)
        self._bottom = 17.0


class _Nowhere:
    """A canvas that draws nothing, to find out how high a step is."""

    def page(self) -> None:
        pass

    def path(self, *args, **fields) -> None:
        pass

    def circle(self, *args, **fields) -> None:
        pass

    def text(self, *args, **fields) -> None:
        pass


class _StepOnPaper:
    """A step: pictures in the left column, text, question and room for the answer in the right one."""

    def __init__(self, lesson: Lesson, step: Step, solutions: bool):
        self._step, self._solutions = step, solutions
        self._situation = situation_on_paper(lesson, step)
        self._facts = _texts_of_measures(self._situation, step)

    def draw(self, canvas: Canvas, heading: str, top: float) -> float:
        """Draw it below a height of the page; return how high it is [mm]."""
        canvas.path([(MARGIN, top), (WIDTH - MARGIN, top)], PALE, 0.3)
        y = top + 2.5
        y += write(canvas, (MARGIN, y), heading, TITLE, WIDTH - 2 * MARGIN, True) + 1.0
        y += write(canvas, (MARGIN, y), _whole(self._fill(self._step.text)), BODY, WIDTH - 2 * MARGIN) + 3.0
        pictures = self._pictures(canvas, y)
        column = _Column(canvas, TEXT_LEFT if pictures else MARGIN, y, TEXT_WIDTH if pictures else WIDTH - 2 * MARGIN)
        if self._step.randomise:
            column.text(FIRST_START, size=SMALL, colour=GREY)
            column.gap(1.0)
        self._question(column)
        if self._solutions:
            self._solution(column)
        else:
            column.gap(1.0)
            column.text("Now say it in one sentence:", bold=True)
            column.blank_lines(2)
        return max(y + pictures, column.y) - top

    def _fill(self, words: str) -> str:
        return re.sub(r"\{([^{}]*)\}", lambda match: self._facts.get(match[1], BLANK), words)

    def _pictures(self, canvas: Canvas, top: float) -> float:
        """Draw what paper can show of the step's figures; return the height [mm]."""
        y = top
        asked = self._step.ask.figure if isinstance(self._step.ask, Place | Predict) else None
        large = [figure for figure in self._step.main if figure.figure in DRAWN]
        width = PICTURES / 2 - 1.5 if len(large) == 2 else PICTURES
        row = 0.0
        for k, figure in enumerate(large[:2]):
            box = MARGIN + k * (width + 3.0), y, width, IMAGE_HEIGHT
            row = max(row, self._draw(canvas, figure, box, figure.figure == asked))
        y += row + (2.0 if row else 0.0)
        small = [figure for figure in self._step.side if figure.figure in "lrLR"][:MAX_SMALL]
        for k, figure in enumerate(small):
            self._draw(canvas, figure, (MARGIN + k * (PICTURES / 2 + 1.5), y, PICTURES / 2 - 1.5, SMALL_HEIGHT), False)
        return y + (SMALL_HEIGHT + 2.0 if small else 0.0) - top

    def _draw(self, canvas: Canvas, figure: Figure, box: Box, is_asked: bool) -> float:
        layers = set(figure.show)
        if self._solutions:
            layers = (layers - set(figure.hide)) | set(figure.reveal)
        if figure.figure == "landscape":
            return posture_map(canvas, box, self._situation, "relief" in layers, self._situation.settings.start_deg)
        if isinstance(canvas, _Nowhere):
            return box[3] + (7.0 if is_asked else 0.0)
        frame: Frame
        if figure.figure in OUTSIDE:
            frame = outside(canvas, box, self._situation, layers)
        else:
            frame = image(canvas, box, self._situation, figure.figure, layers)
        return box[3] + (ruler(canvas, frame, "px") if is_asked and figure.figure in "lrLR" else 0.0)

    def _question(self, column: "_Column") -> None:
        ask = self._step.ask
        column.text(_on_paper(self._fill(ask.question)), bold=True)
        column.gap(1.0)
        if isinstance(ask, Choice):
            right = self._right(ask)
            column.boxes([answer.text for answer in ask.answers], right if self._solutions else None)
            if not self._solutions:
                column.text("because")
                column.blank_lines(1)
        elif isinstance(ask, Number) and not self._solutions:
            column.scale(ask.low, ask.high, ask.unit, ask.logarithmic)
        elif isinstance(ask, Pose) and not self._solutions:
            for slider in self._step.sliders:
                column.text(slider.label)
                column.scale(slider.low, slider.high, "°", False)
        elif isinstance(ask, Do) and not self._solutions:
            column.table(["step", *map(str, range(1, 9))], [ask.measure, *[""] * 8])
            column.table(["step", *map(str, range(9, 17))], [ask.measure, *[""] * 8])
        elif isinstance(ask, Predict) and not self._solutions:
            column.table(["round", *map(str, range(1, ask.times + 1))], ["off by", *[""] * ask.times])
        elif isinstance(ask, Bet) and not self._solutions:
            column.table(
                ["run", *map(str, range(1, ask.times + 1))], ["bet %", *[""] * ask.times], ["true?", *[""] * ask.times]
            )

    def _right(self, ask: Choice) -> int | None:
        """The index of the right answer; None if only a browser computes it."""
        if ask.right is None:
            return next(k for k, answer in enumerate(ask.answers) if answer.right)
        right = self._facts.get(ask.right)
        return round(float(right)) - 1 if right else None

    def _solution(self, column: "_Column") -> None:
        for words in self._replies():
            column.text(_whole(self._fill(words)))
            column.gap(0.8)
        if self._step.headline is not None and self._step.headline.measure in self._facts:
            column.text(f"{self._fill(self._step.headline.label)}: **{self._facts[self._step.headline.measure]}**")
            column.gap(0.8)
        if _whole(self._fill(self._step.after)):
            column.text(_whole(self._fill(self._step.after)), colour=GREY)
            column.gap(0.8)
        column.gap(1.0)
        column.text("Now you can say", size=SMALL, colour=GREY)
        column.text(self._fill(self._step.say))

    def _replies(self) -> Iterable[str]:
        ask = self._step.ask
        if isinstance(ask, Choice):
            right = self._right(ask)
            for k, answer in enumerate(ask.answers):
                yield (
                    f"**{'abcd'[k]}**  {answer.because}"
                    if right is None or k != right
                    else f"**{'abcd'[k]}, right.**  {_bare(answer)}"
                )
        elif isinstance(ask, Number):
            known = (
                f"The answer is **{{{ask.truth}}}**."
                if ask.truth in self._facts
                else "The answer depends on the start."
            )
            yield f"{known} {ask.close}"
            yield f"If it was too large: {ask.far}"
            if ask.less:
                yield f"If it was too small: {ask.less}"
        elif isinstance(ask, Place | Pose):
            yield f"Near: {ask.close}"
            for other in ask.elsewhere if isinstance(ask, Place) else ():
                yield f"Near {other.truth}: {other.because}"
            yield f"Far: {ask.far}"


def _bare(answer: Option) -> str:
    """The reply to the right answer without its first word, "Right"."""
    words = re.sub(r"^Right[.:]\s*", "", answer.because)
    return words[:1].upper() + words[1:]


class _Column:
    """A column of the page that is written from top to bottom."""

    def __init__(self, canvas: Canvas, left: float, top: float, width: float):
        self.canvas, self.left, self.y, self.width = canvas, left, top, width

    def gap(self, height: float) -> None:
        self.y += height

    def text(self, words: str, bold: bool = False, size: float = BODY, colour: str = INK) -> None:
        self.y += write(self.canvas, (self.left, self.y), words, size, self.width, bold, colour)

    def boxes(self, answers: Iterable[str], right: int | None) -> None:
        """Boxes to tick, with a letter each; the right one ticked."""
        for k, answer in enumerate(answers):
            x, y, side = self.left, self.y + 0.6, 3.2
            self.canvas.path([(x, y), (x + side, y), (x + side, y + side), (x, y + side)], INK, 0.3, closed=True)
            if k == right:
                self.canvas.path([(x + 0.6, y + 1.7), (x + 1.4, y + 2.6), (x + 3.0, y + 0.3)], INK, 0.6)
            text = f"{chr(ord('a') + k % 26)})  {answer}"
            self.y += write(self.canvas, (x + 5.0, self.y), text, BODY, self.width - 5.0) + 0.9

    def blank_lines(self, count: int) -> None:
        for _ in range(count):
            self.y += LINE_STEP
            self.canvas.path([(self.left, self.y), (self.left + self.width, self.y)], PALE, 0.25)
        self.y += 2.0

    def scale(self, low: float, high: float, unit: str, logarithmic: bool) -> None:
        """A line with numbers to mark a guess on."""
        left, right, y = self.left + 3.0, self.left + self.width - 8.0, self.y + 6.0
        self.canvas.path([(left, y), (right, y)], INK, 0.4)
        for value in _ticks(low, high, logarithmic):
            x = left + (right - left) * _share(value, low, high, logarithmic)
            self.canvas.path([(x, y - 1.4), (x, y + 1.4)], INK, 0.3)
            words = f"{value:g}".replace("-", "−")
            self.canvas.text((x - text_width(words, 7.0) / 2, y + 4.6), words, 7.0, colour=GREY)
        self.canvas.text((right + 1.5, y + 1.0), unit.strip(), SMALL, colour=GREY)
        self.y += 13.0

    def table(self, *rows: list[str]) -> None:
        """Rows of cells to fill in; the first cell of each is its name."""
        first, height = 3.0 + max(text_width(row[0], 7.5) for row in rows), 6.5
        cell = (self.width - first) / max(len(rows[0]) - 1, 1)
        for row in rows:
            edges = [self.left, *(self.left + first + k * cell for k in range(len(row)))]
            for a, b, words in zip(edges, edges[1:], row):
                corners = [(a, self.y), (b, self.y), (b, self.y + height), (a, self.y + height)]
                self.canvas.path(corners, PALE, 0.25, closed=True)
                self.canvas.text((a + 1.0, self.y + 4.3), words, 7.5)
            self.y += height
        self.y += 2.5


def _ticks(low: float, high: float, logarithmic: bool) -> list[float]:
    if logarithmic:
        marks = [m * 10.0**k for k in range(-4, 5) for m in (1, 2, 5)]
        inside = [mark for mark in marks if low <= mark <= high]
        return [mark for mark in inside if len(inside) <= 9 or f"{mark:e}"[0] == "1"]
    decade = floor(log10(high - low)) - 1
    steps = (factor * 10.0**k for k in (decade, decade + 1) for factor in (1, 2, 5))
    step = next(each for each in steps if (high - low) / each <= 8)
    first = -(-low // step)
    return [step * (first + k) for k in range(20) if step * (first + k) <= high + 1e-9]


def _share(value: float, low: float, high: float, logarithmic: bool) -> float:
    return log(value / low) / log(high / low) if logarithmic else (value - low) / (high - low)


def _on_paper(question: str) -> str:
    """A question as it is answered with a pencil."""
    question = re.sub(r"\bClick (?:on|in) the empty map where\b", "Mark on the empty map with a cross where", question)
    question = re.sub(r"\bClick in the scene\b", "Mark in the picture with a cross", question)
    question = re.sub(r"\bClick in (\w+)\b", r"Mark in \1 with a cross", question)
    return question


def situation_on_paper(lesson: Lesson, step: Step) -> Situation:
    """Return the state that a step shows at first: of those that are sampled the first, sliders where they begin."""
    situation = (sampled_situations(lesson, step) or [situation_of(lesson, step)])[0]
    moved = {slider.name: slider.start for slider in step.sliders if slider.name in ("distance", "baseline")}
    return situation.with_eyes(**moved) if moved else situation


def _texts_of_measures(situation: Situation, step: Step) -> dict[str, str]:
    """Measures of a step that the library computes, as they stand in a sentence."""
    names = sorted(measures_of(step))
    found = {name: fact["text"] for name, fact in facts.compute(situation, names)[0].items()}
    for name in names:
        if name in PAPER_MEASURES and name not in found:
            found[name] = PAPER_MEASURES[name].tell(situation)["text"]
    return found


def _whole(words: str) -> str:
    """Only the sentences that have no blank."""
    return " ".join(sentence for sentence in re.split(r"(?<=[.!?])\s+", words) if BLANK not in sentence)
