"""Names of points in different files: which are certainly the same, and which are in some views only."""

import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from difflib import SequenceMatcher
from itertools import combinations

from ...estimation.views import VIEW_NAMES
from ...wording import first_of
from ..files import MAX_NAME_CHARS, escape

NAMED = 6  # names in one list of a message
MAX_COMPARED = 60  # names whose spellings are compared
NEAR = 0.7  # of difflib's ratio
BETWEEN_DIGITS = re.compile(r"(?<=\d)[\s_.-]+(?=\d)")
WHOLE = re.compile(r"(\d+)\.0*(?:[eE]\+?0+)?|(\d)\.(\d*?)0*[eE]\+?(\d{1,2})")


def point_name(text: str) -> str:
    """Return a name without blanks around it; one that is a whole number as pandas and numpy write it, as that."""
    text = text.strip()
    if WHOLE.fullmatch(text) and (value := float(text)) == int(value) and value < 2**53:
        return str(int(value))
    return text


def spelling_key(name: str) -> str:
    """Return what equal names have in common: all but case, blanks, underscores, hyphens and dots between letters."""
    name = BETWEEN_DIGITS.sub("/", unicodedata.normalize("NFKC", name).casefold().strip())
    return "".join(one for one in name if one not in "_-." and not one.isspace() and one.isprintable()) or name


def same_names(names: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Return other spellings of a name and the usual one, given the names in each view.

    Names that are two points of one view are never taken for one.
    """
    spelled: dict[str, Counter[str]] = {}
    apart = set()
    for of in names.values():
        count = Counter(map(spelling_key, of))
        apart |= {key for key, number in count.items() if number > 1}
        for name in of:
            spelled.setdefault(spelling_key(name), Counter())[name] += 1
    return {
        name: found.most_common(1)[0][0]
        for key, found in spelled.items()
        if len(found) > 1 and key not in apart
        for name in found
        if name != found.most_common(1)[0][0]
    }


def unmatched_names(names: Mapping[str, Collection[str]]) -> str | None:
    """Say which names are not in all of these views, near spellings side by side; None if all are in all."""
    views_of: dict[str, tuple[str, ...]] = {}
    for name in dict.fromkeys(name for of in names.values() for name in of):
        if len(found := tuple(view for view, of in names.items() if name in of)) < len(names):
            views_of[name] = found
    if not views_of:
        return None
    said = []
    for views in dict.fromkeys(views_of.values()):
        those = [escape(name, MAX_NAME_CHARS) for name, of in views_of.items() if of == views]
        said.append(f"{first_of(those, NAMED)} (only {', '.join(VIEW_NAMES[view] for view in views)})")
    near = [f"{escape(a, MAX_NAME_CHARS)} ~ {escape(b, MAX_NAME_CHARS)}" for a, b in _near(views_of)]
    alike = f"; perhaps the same: {', '.join(near[:NAMED])}" if near else ""
    more = f"; and {len(said) - NAMED} more groups" if len(said) > NAMED else ""
    return f"points that are not in all views: {'; '.join(said[:NAMED])}{more}{alike}"


def _near(views_of: Mapping[str, tuple[str, ...]]) -> Iterator[tuple[str, str]]:
    """Pairs of names of different views that may be spellings of one."""
    for a, b in combinations(list(views_of)[:MAX_COMPARED], 2):
        if set(views_of[a]) & set(views_of[b]):
            continue
        if [int(n) for n in re.findall(r"\d{1,9}", a)] != [int(n) for n in re.findall(r"\d{1,9}", b)]:
            continue
        plain = spelling_key(a), spelling_key(b)
        words = [sorted(re.findall(r"[^\W\d_]+", name.casefold())) for name in (a, b)]
        if words[0] == words[1] or SequenceMatcher(None, *plain).ratio() >= NEAR:
            yield a, b
