"""What the numbers and names on the page mean: one file, shown at a "?" beside each and in the help.

A "?" is a button that opens a popover by its id, without a script; the popovers stand in an html of their own, so that
none is closed when the numbers beside its "?" change. Buttons are inputs, as the page's keys are no commands there:
Escape closes the card, and Space asks.
"""

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import msgspec

from ..assets import ROOT
from ..settings import Settings
from . import svg
from .equations import mathml

FILE = ROOT / "glossary.toml"


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """name: a few words; symbol: as the page has it; formula: LaTeX; good, bad: in words, from where on; show: settings
    in which it is bad."""

    name: str
    symbol: str
    sentence: str
    formula: str = ""
    good: str = ""
    bad: str = ""
    show: Settings | None = None


def load(path: Path = FILE) -> dict[str, Entry]:
    """By key, in the file's order. Raises ValueError that names file, entry and field."""
    try:
        read = msgspec.toml.decode(path.read_bytes(), type=dict[str, dict])
    except msgspec.DecodeError as error:
        raise ValueError(f"{path}: {error}") from None
    entries = {}
    for key, fields in read.items():
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


def ask(key: str, style: str = "") -> str:
    """HTML of a "?". Of one entry there should be one at a time: its card opens at the last."""
    name = svg.escape(glossary()[key].symbol)
    place = f' style="{style}"' if style else ""
    told = f'popovertarget="vi-word-{key}" aria-label="What is {name}?"{place}'
    return f'<input type="button" class="vi-ask" value="?" {told}/>'


def asks(keys: Iterable[str]) -> str:
    """A line of symbols, each with its "?"."""
    asked = "".join(f"<span>{svg.escape(glossary()[key].symbol)} {ask(key)}</span>" for key in keys)
    return f'<div class="vi-asked">{asked}</div>'


def beside(key: str) -> str:
    """A "?" at the label of the control that follows, where it takes no room."""
    return f'<div class="vi-at-label">{ask(key)}</div>'


def cards() -> str:
    """HTML of all popovers, which are seen only when opened, each at the "?" that asks for it."""
    anchors = "".join(
        f".vi-ask[popovertarget=vi-word-{key}]{{anchor-name:--vi-word-{key}}}#vi-word-{key}{{position-anchor:--vi-word-{key}}}"
        for key in glossary()
    )
    return f"<style>{anchors}</style>" + "".join(
        f'<div class="vi-word" id="vi-word-{key}" popover="auto"><input type="button" class="vi-close" value="×"'
        f' aria-label="Close" popovertarget="vi-word-{key}" popovertargetaction="hide"/>{_described(entry)}</div>'
        for key, entry in glossary().items()
    )


def listed() -> str:
    """HTML of all entries, for the help."""
    return "".join(f'<div class="vi-entry">{_described(entry)}</div>' for entry in glossary().values())


def _described(entry: Entry) -> str:
    parts = [f"<p><b>{svg.escape(entry.symbol)}</b> <em>{svg.escape(entry.name)}</em></p>"]
    parts.append(f"<p>{svg.escape(entry.sentence)}</p>")
    if entry.formula:
        parts.append(f'<p class="vi-formula">{mathml(entry.formula)}</p>')
    levels = (("good", entry.good), ("bad", entry.bad))
    parts += [f'<p><i class="vi-{level}">{level}</i> {svg.escape(words)}</p>' for level, words in levels if words]
    return "".join(parts)
