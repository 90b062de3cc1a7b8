"""Texts that people see, translated by gettext: mark every one with `_`, or `ngettext` where a number decides its form.

English stands in the code. `assets/locale/viewimit.pot` is the catalog of all texts, from which translators start;
`python -m viewimit.assets.build_catalog` writes it. A process speaks one language, that of its environment (LANGUAGE,
LC_ALL, LC_MESSAGES or LANG), if `assets/locale` has it.

Mark whole sentences, with named fields: `_("Point {name} is hidden.").format(name=…)`.
"""

import gettext
import os
from collections.abc import Callable, Sequence

from .assets import ROOT

DOMAIN = "viewimit"
FOLDER = ROOT / "locale"
_catalog = gettext.translation(DOMAIN, os.environ.get("VIEWIMIT_LOCALE", FOLDER), fallback=True)
_: Callable[[str], str] = _catalog.gettext
ngettext: Callable[[str, str, int], str] = _catalog.ngettext


def sentences(*texts: str) -> str:
    """Join whole sentences, without empty ones. Those of users' own methods get their full stops and capitals."""
    found = [text if text[-1] in ".!?:" else f"{text}." for text in texts if text]
    return " ".join([*found[:1], *(text[0].upper() + text[1:] for text in found[1:])])


def listed(words: Sequence[str]) -> str:
    """Join words as "a, b and c"."""
    if len(words) < 2:
        return "".join(words)
    return _("{first} and {last}").format(first=", ".join(words[:-1]), last=words[-1])


def either(words: Sequence[str]) -> str:
    """Join words as "a, b or c"."""
    if len(words) < 2:
        return "".join(words)
    return _("{first} or {last}").format(first=", ".join(words[:-1]), last=words[-1])
