"""Joining words and sentences that people see."""

from collections.abc import Sequence


def plural(one: str, many: str, n: float) -> str:
    """Return the form of a text that goes with a number."""
    return one if n == 1 else many


def sentences(*texts: str) -> str:
    """Join whole sentences, without empty ones. Those of users' own methods get their full stops and capitals."""
    found = [text if text[-1] in ".!?:" else f"{text}." for text in texts if text]
    return " ".join([*found[:1], *(text[0].upper() + text[1:] for text in found[1:])])


def listed(words: Sequence[str]) -> str:
    """Join words as "a, b and c"."""
    return _joined(words, "and")


def either(words: Sequence[str]) -> str:
    """Join words as "a, b or c"."""
    return _joined(words, "or")


def _joined(words: Sequence[str], last: str) -> str:
    return "".join(words) if len(words) < 2 else f"{', '.join(words[:-1])} {last} {words[-1]}"


def first_of(words: Sequence[str], most: int) -> str:
    """Join the first words as "a, b and 3 more"."""
    return ", ".join(words[:most]) + (f" and {len(words) - most} more" if len(words) > most else "")
