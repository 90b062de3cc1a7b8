"""The documentation's own modules can be imported: its directives, and what makes its pictures."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))
