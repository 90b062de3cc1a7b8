"""Equations with the numbers of one moment, as plain data: LaTeX with holes, and what goes into them.

No drawing and no simulation in here: each transfer and servo says its own equations, `drawing.equations` renders them.
"""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

MARK = "@"
HOLE = rf"\text{{{MARK}}}"  # stands in LaTeX where a number goes
MINUS, MISSING = "−", "–"


@dataclass(frozen=True)
class Equation:
    """number: in the paper, such as "(4)", "" if it is not from there; title: what is shown of it; latex: with a HOLE
    for each of `numbers`; note: HTML; long, wide: whether it is one long line, whether it holds matrices.

    Raises ValueError unless there are as many numbers as holes.
    """

    number: str
    title: str
    latex: str
    numbers: tuple[str, ...] = ()
    note: str = ""
    long: bool = False
    wide: bool = False

    def __post_init__(self):
        holes = self.latex.count(HOLE)
        if len(self.numbers) != holes:
            raise ValueError(f"{len(self.numbers)} numbers for {holes} holes in {self.latex}")


def number(value: float, digits: int = 1) -> str:
    """A real minus, a dash for what is not a number, and no minus before a rounded zero."""
    if not -np.inf < value < np.inf:
        return "∞" if value == np.inf else MISSING
    text = f"{value:.{digits}f}"
    if text[0] == "-":
        text = text[1:] if float(text) == 0 else MINUS + text[1:]
    return text


def with_minus(words: str) -> str:
    """A sentence from elsewhere with a real minus before its negative numbers."""
    return re.sub(r"(?<![\w)\]])-(?=[\d.])", MINUS, words)


def short(value: float) -> str:
    """Fewer digits the larger the number."""
    return number(value, 2 if abs(value) < 10 else 1 if abs(value) < 100 else 0)


def signed(value: float, digits: int) -> str:
    """A term of a sum: its sign, then the number, with spaces."""
    text = number(value, digits)
    return f" {text[0]} {text[1:]}" if text.startswith(MINUS) else f" + {text}"


def each(values: ArrayLike, digits: int) -> list[str]:
    """The entries of an array, row by row. A zero that is one by construction has no decimals."""
    return [number(value, digits if value else 0) for value in np.asarray(values).ravel().tolist()]


def angles(rad: ArrayLike) -> str:
    """Angles in rad as degrees, listed."""
    degrees = np.degrees(rad).tolist()
    return ", ".join(number(value, 2 if abs(value) < 1 else 1) + "°" for value in degrees)


def matrix(rows: int, columns: int) -> str:
    """LaTeX of a matrix of holes."""
    body = r"\\".join("&".join([HOLE] * columns) for _ in range(rows))
    return rf"\begin{{bmatrix}}{body}\end{{bmatrix}}"


def column(count: int) -> str:
    return matrix(count, 1)


def row(count: int) -> str:
    return matrix(1, count)
