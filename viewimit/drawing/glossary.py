"""The glossary: the meaning of numbers and names, read from one file and shown at a "?" beside each.

A "?" is a button that opens a popover by its id, without a script. The popovers are a separate piece of HTML, so that
none closes when the numbers beside its "?" change. Escape closes a card; Space opens it.
"""

import math
from collections.abc import Callable
from functools import cache, lru_cache

import msgspec

from ..assets import ROOT
from ..loop.settings import PAPER_FIELDS, Settings
from . import svg
from .equations import mathml

FILE = ROOT / "glossary.toml"


class Scale(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A logarithmic scale of a number."""

    ends: tuple[float, float]
    good: float  # values on this side of it are good
    bad: float  # values beyond it are bad; below `good` if large values are good
    unit: str = ""

    def share(self, value: float) -> float:
        """Return where a value lies on the scale, from 0 to 1."""
        low, high = self.ends
        return math.log(min(max(value, low), high) / low) / math.log(high / low)


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One word of the glossary."""

    name: str  # a few words
    symbol: str  # as the page writes it
    sentence: str
    show: Settings  # an example, a bad one if possible; fields that the file omits are the paper's
    plays: bool = False  # whether the example takes motions
    formula: str = ""  # LaTeX
    good: str = ""  # which values are good, in words
    bad: str = ""
    scale: Scale | None = None  # of a number that the page knows at every moment
    terms: tuple[str, ...] = ()  # other words for it, by which texts name it


@cache
def glossary() -> dict[str, Entry]:
    """Read the entries by key, in the file's order. What an example omits is the paper's."""
    read = msgspec.toml.decode(FILE.read_bytes())
    for fields in read.values():
        fields["show"] = {**PAPER_FIELDS, **fields["show"]}
    return msgspec.convert(read, dict[str, Entry])


def key_of(symbol: str) -> str | None:
    """Find the key of the entry with this symbol; None if there is none, as for a user's own method."""
    return next((key for key, entry in glossary().items() if entry.symbol == symbol), None)


@lru_cache(256)
def ask(key: str, style: str = "") -> str:
    """Build a "?" for an entry. If a page has several of one entry, its card opens at the last. style: CSS."""
    words = svg.escape(f"What is {glossary()[key].symbol}?")
    place = f' style="{style}"' if style else ""
    attributes = f'popovertarget="vi-word-{key}" aria-label="{words}"{place}'
    return f'<button type="button" class="vi-ask" {attributes}></button>'


def cards(links: Callable[[str], str] = lambda key: "") -> str:
    """Build all popovers, each at the "?" that opens it. links: HTML to add to the card of a key."""
    anchors = "".join(
        f".vi-ask[popovertarget=vi-word-{key}]{{anchor-name:--vi-word-{key}}}#vi-word-{key}{{position-anchor:--vi-word-{key}}}"
        for key in glossary()
    )
    words = "".join(
        f'<div class="vi-word" id="vi-word-{key}" popover="auto"><button type="button" class="vi-close"'
        f' aria-label="Close" popovertarget="vi-word-{key}" popovertargetaction="hide"></button>{links(key)}'
        f"{describe_entry(entry)}</div>"
        for key, entry in glossary().items()
    )
    return f"<style>{anchors}</style>{words}"


def describe_entry(entry: Entry) -> str:
    """Build the HTML of an entry: words, formula, scale, good and bad values."""
    parts = [f"<p><b>{svg.escape(entry.symbol)}</b> <em>{svg.escape(entry.name)}</em></p>"]
    parts.append(f"<p>{svg.escape(entry.sentence)}</p>")
    if entry.formula:
        parts.append(f'<p class="vi-formula" tabindex="0">{mathml(entry.formula)}</p>')
    if entry.scale is not None:
        parts.append(_scale(entry.scale))
    levels = (("good", "good", entry.good), ("bad", "bad", entry.bad))
    parts += [f'<p><i class="vi-{kind}">{name}</i> {svg.escape(words)}</p>' for kind, name, words in levels if words]
    return "".join(parts)


def _scale(scale: Scale) -> str:
    """Draw a bar with its ends and limits; a style that changes with the number marks its value."""
    marks = {value: f"{100 * scale.share(value):.1f}%" for value in (*scale.ends, scale.good, scale.bad)}
    numbers = "".join(f'<span style="left:{place}">{value:g}</span>' for value, place in marks.items())
    kind = "vi-scale" if scale.good < scale.bad else "vi-scale vi-scale-up"
    first, second = (marks[value] for value in sorted((scale.good, scale.bad)))
    return f'<div class="{kind}" style="--first:{first};--second:{second}"><i></i>{numbers}</div>'
