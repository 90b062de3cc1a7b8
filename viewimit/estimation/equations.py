"""How equations are written for the page and for files: LaTeX with holes, and the numbers that fill them.

The method's mathematics is in the other modules. The registries of transfers and servos build equations, and
`drawing.equations` renders them.
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
    """One equation. Raises ValueError unless there are as many numbers as holes."""

    number: str  # in the paper, such as "(4)"; "" if it is not from there
    title: str
    latex: str  # with a HOLE for each of `numbers`
    numbers: tuple[str, ...] = ()
    note: str = ""  # HTML
    long: bool = False  # whether it is one long line
    wide: bool = False  # whether it holds matrices
    lines: tuple[
        str, ...
    ] = ()  # by row of its first matrix: images of an epipolar line, such as "lL", that the row is of

    def __post_init__(self) -> None:
        holes = self.latex.count(HOLE)
        if len(self.numbers) != holes:
            raise ValueError(f"{len(self.numbers)} numbers for {holes} holes in {self.latex}")


def number(value: float, digits: int = 1) -> str:
    """Format a number with a real minus, a dash for NaN, and no minus before a rounded zero."""
    if not -np.inf < value < np.inf:
        return "∞" if value == np.inf else MISSING
    text = f"{value:.{digits}f}"
    if text[0] == "-":
        text = text[1:] if float(text) == 0 else MINUS + text[1:]
    return text


def with_minus(words: str) -> str:
    """Replace the hyphen before negative numbers in a sentence by a real minus."""
    return re.sub(r"(?<![\w)\]])-(?=[\d.])", MINUS, words)


def short(value: float) -> str:
    """Format a number with fewer digits the larger it is."""
    return number(value, 2 if abs(value) < 10 else 1 if abs(value) < 100 else 0)


def signed(value: float, digits: int) -> str:
    """Format a term of a sum: sign and number, with spaces."""
    text = number(value, digits)
    return f" {text[0]} {text[1:]}" if text.startswith(MINUS) else f" + {text}"


def each(values: ArrayLike, digits: int) -> list[str]:
    """Format the entries of an array, row by row; an exact zero has no decimals."""
    return [number(value, digits if value else 0) for value in np.asarray(values).ravel().tolist()]


def angles(rad: ArrayLike) -> str:
    """Format angles [rad] as a list in degrees."""
    degrees = np.degrees(rad).tolist()
    return ", ".join(number(value, 2 if abs(value) < 1 else 1) + "°" for value in degrees)


def matrix(rows: int, columns: int) -> str:
    """Return LaTeX of a matrix of holes."""
    body = r"\\".join("&".join([HOLE] * columns) for _ in range(rows))
    return rf"\begin{{bmatrix}}{body}\end{{bmatrix}}"


def column(count: int) -> str:
    """Return LaTeX of a column of holes."""
    return matrix(count, 1)


def row(count: int) -> str:
    """Return LaTeX of a row of holes."""
    return matrix(1, count)
