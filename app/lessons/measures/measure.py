"""A number, place or posture that a step can ask for and reveal."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from viewimit.drawing import svg

from ..stage import Stage


@dataclass(frozen=True)
class Measure:
    """of: a stage → a number, NaN where there is none, or an array that is a place or a posture; unit: behind the
    number; digits: after the point, None for as many as it deserves; missing: what is told of NaN."""

    of: Callable[[Stage], Any]
    unit: str = ""
    digits: int | None = None
    missing: str = "–"

    def told(self, stage: Stage) -> str:
        """With its unit."""
        value = float(self.of(stage))
        if not np.isfinite(value):
            return self.missing
        number = svg.short(value) if self.digits is None else svg.number(value, self.digits)
        return number + self.unit
