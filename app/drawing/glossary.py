"""The glossary on the page: every "?", the cards with links to examples, and the numbers' values on their scales."""

import math
from collections.abc import Iterable, Mapping

from viewimit.drawing import svg
from viewimit.drawing.glossary import ask, cards, describe_entry, glossary
from viewimit.language import _

from .overlays import link


def asks(keys: Iterable[str]) -> str:
    """Build a line of symbols, each with its "?"."""
    items = "".join(f"<span>{svg.escape(glossary()[key].symbol)} {ask(key)}</span>" for key in keys)
    return f'<div class="vi-asked">{items}</div>'


def beside(key: str) -> str:
    """Build a "?" at the label of the control that follows, where it takes no room."""
    return f'<div class="vi-at-label">{ask(key)}</div>'


def linked_cards() -> str:
    """Build all cards with links to their examples."""
    back = link("restore/0", _("Back to what was here before"), _("Back to before"))
    restore = f'<span class="vi-show vi-give-back">{back}</span>'  # hidden until the example is shown
    return cards(lambda key: _show(key) + restore)


def listed() -> str:
    """Build all entries for the help, with links to their examples."""
    return "".join(
        f'<div class="vi-entry">{_show(key)}{describe_entry(entry)}</div>' for key, entry in glossary().items()
    )


def current_values(values: Mapping[str, float], shown: str | None = None) -> str:
    """Build a style that marks the present values on the cards' scales, so that open cards stay as they are.

    values: by key; NaN is left out. shown: the entry whose card offers to restore the session before its example.
    """
    rules = [] if shown is None else [f"#vi-word-{shown} .vi-give-back{{display:block}}"]
    for key, value in values.items():
        scale = glossary()[key].scale
        if scale is not None and math.isfinite(value):
            number = str(value) if isinstance(value, int) else svg.short(value)  # a count has no decimals
            words = _("now {value}").format(value=f"{number}{scale.unit}")
            rules.append(f'#vi-word-{key}{{--now:{100 * scale.share(value):.1f}%;--words:"{words}"}}')
    return f"<style>{''.join(rules)}</style>"


def _show(key: str) -> str:
    """Build the link to an entry's example."""
    entry = glossary()[key]
    if entry.bad:
        name, words = _("Show me a bad one: {symbol}"), _("Show me a bad one")
    else:
        name, words = _("Show me: {symbol}"), _("Show me")
    return f'<span class="vi-show">{link(f"show/{key}", name.format(symbol=entry.symbol), words)}</span>'
