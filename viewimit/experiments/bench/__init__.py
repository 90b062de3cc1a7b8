"""Studies behind the published figures, each reproducible from a seed. They judge nothing by the paper.

`engine` makes and judges runs, `cases` has the conditions, `report` lays out what was found.
"""

from .cases import GROUPS
from .engine import Case, Draw, Group, Run, run_cases, summarise

__all__ = ["GROUPS", "Case", "Draw", "Group", "Run", "run_cases", "summarise"]
