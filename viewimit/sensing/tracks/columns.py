"""What the columns of a table and the arrays of a file mean, by their names: alike in every format.

A column holds frames, views, names of points, x or y, or it says whether a point is seen. One that changes what x and y
are makes the table unreadable. All others are not read, which is said.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...wording import first_of
from ..files import MAX_NAME_CHARS, escape

NAMED = 20  # columns that are not read, in words


class Meaning(Enum):
    """What a column is about."""

    FRAME = "frame"
    PICTURE = "picture"  # tells the frames if nothing numbers them
    TIME = "time"  # numbers the frames if nothing else tells them
    VIEW = "view"
    POINT = "point"
    PART = "part"  # names the points if nothing else does
    X = "x"
    Y = "y"
    CONFIDENCE = "confidence"
    VISIBLE = "visible"  # 1 or yes if the point is seen; or COCO's 0, 1, 2
    HIDDEN = "hidden"  # 1 or yes if it is not
    UNIT = "unit"
    SPACE = "space"
    BOX = "box"
    NO_PIXELS = "no pixels"
    UNREAD = "unread"


SEEN = (Meaning.CONFIDENCE, Meaning.VISIBLE, Meaning.HIDDEN)
INSTEAD = ((Meaning.FRAME, Meaning.PICTURE), (Meaning.FRAME, Meaning.TIME), (Meaning.POINT, Meaning.PART))
ONE_EACH = (Meaning.FRAME, Meaning.VIEW, Meaning.POINT, Meaning.X, Meaning.Y)
REFUSED = {
    Meaning.SPACE: "points in space, but x and y must be pixels of one picture. If they are, leave this column out",
    Meaning.BOX: "boxes, whose x and y may be a corner or the centre. Write the point itself as x and y, without this",
    Meaning.NO_PIXELS: "no pixels. Write x and y in pixels",
}
_POINT = "(?:is|was|points?|keypoints?|kpts?|kp|joints?|markers?|nodes?|bodyparts?|landmarks?|pred(?:icted)?|label)*"
_SEEN = "visibles?|visibility|visibilities|vis|seen|present|presence|valid|detected|found|inlier|tracked|"
_SEEN += "trackingstat(?:e|us)|in(?:view|frame|image|picture)"
_LOST = "occluded|occlusions?|hidden|missing|lost|absent|outliers?|outside|excluded|"
_LOST += "out(?:of)?(?:view|frame|image|picture)"
_DEGREE = "(?:flags?|masks?|values?|scores?|prob|probability|conf|confidence|levels?|stat(?:e|us)|percent|pct)?"
NAMES = {  # of columns, in lower case without punctuation; % reads percent
    Meaning.FRAME: "frames?|frame(?:idx|index|id|no|num|number)|image|image(?:id|idx|index)|t",
    Meaning.PICTURE: "image(?:name|file)|img|picture|filename|slice",
    Meaning.VIEW: "view",
    Meaning.POINT: "points?|point(?:id|name)|name|id|keypoint|keypoint(?:id|name)|bodyparts?|node|nodename|trackid|"
    "point3did|classid|marker|markerid|label|particle|tag|tagid",
    Meaning.PART: "landmark|landmark(?:id|name)|joint|joint(?:id|name)|part",
    Meaning.X: "x|xpx|x?u|upx|ptx|px|posx|positionx|x(?:in)?pixels?",
    Meaning.Y: "y|ypx|y?v|vpx|pty|py|posy|positiony|y(?:in)?pixels?",
    Meaning.TIME: "(?:time|timestamps?|stamp|ts)(?:in)?(?:s|ms|us|ns|secs?|seconds|nsecs?)?",
    Meaning.HIDDEN: f"{_POINT}(?:{_LOST}|(?:not|non|un|in)(?:{_SEEN})){_DEGREE}",
    Meaning.VISIBLE: f"{_POINT}(?:{_SEEN}|(?:not|non|un)(?:{_LOST})){_DEGREE}",
    Meaning.CONFIDENCE: f"{_POINT}(?:confidences?|conf|likelihoods?|scores?|probability|probabilities|prob|certainty|c)"
    "(?:scores?|values?|levels?|percent|pct)*",
    Meaning.UNIT: "(?:xy|coordinates?|coords?)?units?",
    Meaning.SPACE: "(?:pos(?:ition)?|pt|p|world|cam(?:era)?)?z(?:3d|mm|cm|m|px|pixels?|world|norm)?|"
    "(?:point|keypoint)?depths?(?:mm|cm|m)?",
    Meaning.BOX: "(?:b?box|rect)?(?:w|h|width|height|x2|y2|xmax|ymax|right|bottom)",
    Meaning.NO_PIXELS: "(?:pos|position)?[xyuv](?:in)?(?:mm|cm|m|um|µm|μm|inch|inches|deg|degrees|rad|norm|normed|"
    "normali[sz]ed|rel|relative|percent|pct|ndc|world|3d|shares?|fraction|ratio)|"
    "(?:norm|normali[sz]ed|rel|relative|world)[xyuv]",
}
PATTERNS = {meaning: re.compile(pattern) for meaning, pattern in NAMES.items()}
PIXELS = ("", "px", "pix", "pixel", "pixels")  # of a column of units
YES, NO = ("true", "t", "yes", "y", "on"), ("false", "f", "no", "n", "off")
HIDDEN_WORDS = re.compile(f"{NAMES[Meaning.HIDDEN]}|out")
VISIBLE_WORDS = re.compile(f"{_SEEN}|in|ok|good|certain|visibly")


def plain_name(name: str) -> str:
    """Return a heading in lower case without punctuation."""
    return "".join(filter(str.isalnum, name.replace("%", "percent").lower()))


def meaning_of(name: str) -> Meaning:
    """Return what a column or array of this name means."""
    plain = plain_name(name)
    return next((meaning for meaning, pattern in PATTERNS.items() if pattern.fullmatch(plain)), Meaning.UNREAD)


@dataclass(frozen=True)
class Columns:
    """Where the columns of one table are."""

    at: dict[Meaning, int]  # of ONE_EACH, those that there are
    seen: tuple[tuple[int, Meaning], ...]  # columns that say whether a point is seen, and how
    units: tuple[int, ...]
    unread: tuple[str, ...]


def find_columns(where: str, heading: Sequence[str]) -> Columns:
    """Classify the columns of a table.

    Raises ValueError if two columns could be meant, or one changes what x and y are.
    """
    names = [name.strip() for name in heading]
    meant = [meaning_of(name) for name in names]
    plain = [plain_name(name) for name in names]
    if "v" in plain and "u" not in plain and meant.count(Meaning.Y) > 1:  # COCO's x, y, v
        meant[plain.index("v")] = Meaning.VISIBLE
    for lacking, instead in INSTEAD:
        if lacking not in meant and meant.count(instead) == 1:
            meant[meant.index(instead)] = lacking
    at: dict[Meaning, int] = {}
    for meaning in ONE_EACH:
        found = [k for k, one in enumerate(meant) if one is meaning]
        exact = [k for k in found if plain[k] == meaning.value]
        if len(found) > 1 and len(exact) != 1:
            if len({names[k].lower() for k in found}) == 1:
                raise ValueError(f"{where}: two columns are named {names[found[0]]}: keep one of them")
            named = " or ".join(names[k] for k in found)
            raise ValueError(f"{where}: is {meaning.value} the column {named}? Keep one of them, as {meaning.value}")
        if found:
            at[meaning] = (exact or found)[0]
    refuse(where, [name for name, one in zip(names, meant) if one is not Meaning.NO_PIXELS or Meaning.X not in at])
    seen = tuple((k, one) for k, one in enumerate(meant) if one in SEEN)
    units = tuple(k for k, one in enumerate(meant) if one is Meaning.UNIT)
    read = {*at.values(), *(k for k, _ in seen), *units}
    unread = [name or f"number {k + 1}" for k, name in enumerate(names) if k not in read]
    return Columns(at, seen, units, tuple(unread))


def refuse(where: str, names: Iterable[str]) -> None:
    """Raise ValueError for the first column that changes what x and y are."""
    for name in names:
        if why := REFUSED.get(meaning_of(name)):
            raise ValueError(f"{where}: column {escape(name, MAX_NAME_CHARS)}: {why}")


def require_pixel_unit(where: str, unit: str) -> None:
    """Raise ValueError for a unit that is not the pixel."""
    if unit.strip().lower() not in PIXELS:
        raise ValueError(
            f"{where}: x and y are in {escape(unit.strip(), MAX_NAME_CHARS)}: {REFUSED[Meaning.NO_PIXELS]}"
        )


def name_unread(kind: str, names: Iterable[str]) -> str:
    """Name the columns or arrays that are not read; empty without any."""
    escaped = [escape(name, MAX_NAME_CHARS) for name in dict.fromkeys(names)]
    return f"{kind}{'s' if len(escaped) > 1 else ''} {first_of(escaped, NAMED)}" if escaped else ""


@lru_cache(256)
def word_as_number(meaning: Meaning, text: str) -> float | None:
    """Return 1 or 0, as a column of this meaning writes it in numbers, for a word; None for any other text."""
    word = text.strip().lower()
    if word in YES or word in NO:
        return float(word in YES)
    plain = plain_name(word)
    if VISIBLE_WORDS.fullmatch(plain):
        return float(meaning is not Meaning.HIDDEN)
    return float(meaning is Meaning.HIDDEN) if HIDDEN_WORDS.fullmatch(plain) else None


def as_numbers(where: str, meaning: Meaning, values: NDArray[np.generic]) -> NDArray[np.float64]:
    """Return an array of numbers, truth values or words as numbers. Raises ValueError for other words."""
    if values.dtype.kind in "biuf":
        return values.astype(float)
    texts, at = np.unique([_text(one) for one in values.ravel().tolist()], return_inverse=True)
    return np.array([_number(where, meaning, text) for text in texts.tolist()])[at].reshape(values.shape)


def _text(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _number(where: str, meaning: Meaning, text: str) -> float:
    number = word_as_number(meaning, text)
    try:
        return float(text) if number is None else number
    except ValueError:
        raise ValueError(f"{where}: {escape(text, MAX_NAME_CHARS)!r} is neither a number nor yes or no") from None
