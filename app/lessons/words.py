"""Words and numbers of lessons as HTML."""

import re

from viewimit.drawing.svg import escape


def inline(words: str) -> str:
    """Escaped, with **bold**."""
    return re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", escape(words))


def shown(value: float) -> str:
    """A number that was chosen or set, as it is written."""
    return f"{value:g}".replace("-", "−")


def heading(inside: str) -> str:
    """Of a screen: the focus begins there."""
    return f'<h2 tabindex="-1">{inside}</h2>'
