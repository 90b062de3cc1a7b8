"""What a figure of a step is: its layers, how it is drawn, and what a click in it means."""

from collections.abc import Callable, Collection
from dataclasses import dataclass

from numpy.typing import NDArray

from ..stage import Stage


@dataclass(frozen=True)
class FigureKind:
    """draw(stage, layers, small): HTML, at the side or not; unplace(stage, at): (2,) units of the drawing → what is
    there, in the figure's unit, None if it cannot be clicked; works: what it shows the outcome of, by name."""

    draw: Callable[[Stage, Collection[str], bool], str]
    layers: tuple[str, ...] = ()
    unplace: Callable[[Stage, NDArray], NDArray] | None = None
    works: tuple[str, ...] = ()
