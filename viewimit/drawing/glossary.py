"""What the numbers and names on the page mean: one file, shown at a "?" beside each and in the help.

A "?" is a button that opens a popover by its id, without a script; the popovers stand in an html of their own, so that
none is closed when the numbers beside its "?" change. Buttons are inputs, as the page's keys are no commands there:
Escape closes the card, and Space asks.
"""

import math
from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from pathlib import Path

import msgspec

from ..assets import ROOT
from ..loop.settings import PAPER_FIELDS, Settings
from . import svg
from .equations import mathml
from .over.links import link, sink

FILE = ROOT / "glossary.toml"


class Scale(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Of a number, logarithmic, between its ends; up to good, or down to it, it is good, and from bad on bad."""

    ends: tuple[float, float]
    good: float
    bad: float
    unit: str = ""

    def share(self, value: float) -> float:
        """Of the scale's length, 0 … 1, that lies before a value."""
        low, high = self.ends
        return math.log(min(max(value, low), high) / low) / math.log(high / low)


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """name: a few words; symbol: as the page has it; formula: LaTeX; good, bad: in words, from where on; show: settings
    in which it is bad, or is seen at all, the rest as the paper's; plays: whether that takes motions; scale: of a
    number that the page knows at every moment."""

    name: str
    symbol: str
    sentence: str
    show: Settings
    plays: bool = False
    formula: str = ""
    good: str = ""
    bad: str = ""
    scale: Scale | None = None


def load(path: Path = FILE) -> dict[str, Entry]:
    """By key, in the file's order. Raises ValueError that names file, entry and field."""
    try:
        read = msgspec.toml.decode(path.read_bytes(), type=dict[str, dict])
    except msgspec.DecodeError as error:
        raise ValueError(f"{path}: {error}") from None
    entries = {}
    for key, fields in read.items():
        if isinstance(fields.get("show"), dict):
            fields = {**fields, "show": {**PAPER_FIELDS, **fields["show"]}}
        try:
            entries[key] = msgspec.convert(fields, Entry)
        except msgspec.ValidationError as error:
            raise ValueError(f"{path}: entry {key!r}: {error}") from None
    return entries


@cache
def glossary() -> dict[str, Entry]:
    """The shipped one."""
    return load()


def key_of(symbol: str) -> str | None:
    """Of the entry with this symbol; None if it has none, as methods from outside may."""
    return next((key for key, entry in glossary().items() if entry.symbol == symbol), None)


@lru_cache(256)
def ask(key: str, style: str = "") -> str:
    """HTML of a "?". Of one entry there should be one at a time: its card opens at the last."""
    name = svg.escape(glossary()[key].symbol)
    place = f' style="{style}"' if style else ""
    told = f'popovertarget="vi-word-{key}" aria-label="What is {name}?"{place}'
    return f'<button type="button" class="vi-ask" {told}></button>'


def asks(keys: Iterable[str]) -> str:
    """A line of symbols, each with its "?"."""
    asked = "".join(f"<span>{svg.escape(glossary()[key].symbol)} {ask(key)}</span>" for key in keys)
    return f'<div class="vi-asked">{asked}</div>'


def beside(key: str) -> str:
    """A "?" at the label of the control that follows, where it takes no room."""
    return f'<div class="vi-at-label">{ask(key)}</div>'


def cards(address: str | None = None) -> str:
    """HTML of all popovers, which are seen only when opened, each at the "?" that asks for it. address: that the links
    to what they show begin with, None for none."""
    anchors = "".join(
        f".vi-ask[popovertarget=vi-word-{key}]{{anchor-name:--vi-word-{key}}}#vi-word-{key}{{position-anchor:--vi-word-{key}}}"
        for key in glossary()
    )
    words = "".join(
        f'<div class="vi-word" id="vi-word-{key}" popover="auto"><button type="button" class="vi-close"'
        f' aria-label="Close" popovertarget="vi-word-{key}" popovertargetaction="hide"></button>{_show(address, key)}'
        f"{_give_back(address)}{_described(entry)}</div>"
        for key, entry in glossary().items()
    )
    return f"<style>{anchors}</style>{words}{sink() if address else ''}"


def listed(address: str | None = None) -> str:
    """HTML of all entries, for the help."""
    return "".join(
        f'<div class="vi-entry">{_show(address, key)}{_described(entry)}</div>' for key, entry in glossary().items()
    )


def told_now(values: Mapping[str, float], shown: str | None = None) -> str:
    """A style that says on the cards' scales what the numbers are now, by key; those that are NaN are not said. The
    cards themselves stay as they are, and so open. shown: the entry whose card offers to give back what was there."""
    rules = [] if shown is None else [f"#vi-word-{shown} .vi-give-back{{display:block}}"]
    for key, value in values.items():
        scale = glossary()[key].scale
        if scale is not None and math.isfinite(value):
            told = f"now {svg.short(value)}{scale.unit}"
            rules.append(f'#vi-word-{key}{{--now:{100 * scale.share(value):.1f}%;--told:"{told}"}}')
    return f"<style>{''.join(rules)}</style>"


def _show(address: str | None, key: str) -> str:
    """The link to what an entry shows."""
    if address is None:
        return ""
    entry = glossary()[key]
    words = "Show me a bad one" if entry.bad else "Show me"
    return f'<span class="vi-show">{link(address, f"show/{key}", f"{words}: {entry.symbol}", words)}</span>'


def _give_back(address: str | None) -> str:
    """The link that takes it away again, unseen until it is shown."""
    if address is None:
        return ""
    back = link(address, "restore/0", "Give it back: what was here before", "Give it back")
    return f'<span class="vi-show vi-give-back">{back}</span>'


def _described(entry: Entry) -> str:
    parts = [f"<p><b>{svg.escape(entry.symbol)}</b> <em>{svg.escape(entry.name)}</em></p>"]
    parts.append(f"<p>{svg.escape(entry.sentence)}</p>")
    if entry.formula:
        parts.append(f'<p class="vi-formula">{mathml(entry.formula)}</p>')
    if entry.scale is not None:
        parts.append(_scale(entry.scale))
    levels = (("good", entry.good), ("bad", entry.bad))
    parts += [f'<p><i class="vi-{level}">{level}</i> {svg.escape(words)}</p>' for level, words in levels if words]
    return "".join(parts)


def _scale(scale: Scale) -> str:
    """A bar with its ends, and from where on it is good and bad; where it is now is told apart."""
    marks = {value: f"{100 * scale.share(value):.1f}%" for value in (*scale.ends, scale.good, scale.bad)}
    numbers = "".join(f'<span style="left:{place}">{value:g}</span>' for value, place in marks.items())
    kind = "vi-scale" if scale.good < scale.bad else "vi-scale vi-scale-up"
    first, second = (marks[value] for value in sorted((scale.good, scale.bad)))
    return f'<div class="{kind}" style="--first:{first};--second:{second}"><i></i>{numbers}</div>'
