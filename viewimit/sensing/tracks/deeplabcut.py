"""DeepLabCut's tables, as CSV: rows of headings, scorer, individuals where there are several, bodyparts, coords, then a
row a frame, by its number or the path of its picture. Predictions have x, y, likelihood, CollectedData x and y."""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import islice
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from .cells import MOST_FRAME, Table
from .track import CERTAIN, Track

LEVELS = (("scorer", "bodyparts", "coords"), ("scorer", "individuals", "bodyparts", "coords"))
Heading = tuple[str, str, str]  # individual, body part, coordinate; individual "" where there is one
SINGLE = "single"  # DeepLabCut's name of what belongs to no individual


def read_deeplabcut_csv(path: Path, individual: str | None) -> Track:
    """Raises ValueError that names the file, and the line and column of what is wrong; OSError."""
    table = Table(path)
    lines = table.lines()
    head = list(islice(lines, 3))
    if len(head) > 1 and head[1][1][0] == "individuals":
        head += islice(lines, 1)
    levels = tuple(cells[0] for _, cells in head)
    if levels not in LEVELS:
        wanted = " or ".join(", ".join(names) for names in LEVELS)
        raise ValueError(f"{path}: its first lines must begin with {wanted}, as DeepLabCut's do")
    line, parts = head[-2]
    for other, cells in head:
        table.require_count(other, cells, len(parts))
    first = next((k for k, name in enumerate(parts[1:], 1) if name), len(parts))  # before it stands which frame it is
    several = head[1][1] if len(levels) == 4 else [""] * len(parts)
    headings = list(zip(several[first:], parts[first:], head[-1][1][first:]))
    frames, numbers = [], []
    for line, cells in lines:
        table.require_count(line, cells, len(parts))
        frames.append(frame_of(f"{path}: line {line}, column 1", cells[:first]))
        numbers.append(
            [
                table.number(line, f"{first + k + 1} ({part} {coordinate})", cells[first + k], np.nan)
                for k, (_, part, coordinate) in enumerate(headings)
            ]
        )
    values = np.array(numbers).reshape(len(frames), len(headings))
    return track_of(str(path), headings, np.array(frames, int), values, individual)


def track_of(
    where: str, headings: Sequence[Heading], frames: NDArray, values: NDArray, individual: str | None
) -> Track:
    """values: (T, columns). Raises ValueError that names the file and the column."""
    chosen = choose(where, list(dict.fromkeys(one for one, _, _ in headings if one != SINGLE)), individual)
    several = [heading for heading, count in Counter(headings).items() if count > 1 and heading[0] == chosen]
    if several:
        _, part, name = several[0]
        raise ValueError(f"{where}: two columns are {name} of {part!r}: keep those of one scorer")
    columns = {(part, name): k for k, (one, part, name) in enumerate(headings) if one == chosen}
    parts = list(dict.fromkeys(part for part, _ in columns))
    for part in parts:
        if not {(part, "x"), (part, "y")} <= columns.keys():
            raise ValueError(f"{where}: body part {part!r} needs columns x and y, and likelihood if it is known")
    if not parts:
        raise ValueError(f"{where}: no body part")
    image = np.stack([values[:, [columns[part, "x"], columns[part, "y"]]] for part in parts], 1)
    sure = [values[:, columns[part, "likelihood"]] if (part, "likelihood") in columns else None for part in parts]
    likelihood = np.stack([np.full(len(values), CERTAIN) if one is None else one for one in sure], 1)
    order = np.argsort(frames, kind="stable")
    twice = np.flatnonzero(np.diff(frames[order]) == 0)
    if len(twice):
        raise ValueError(f"{where}: frame {frames[order][twice[0]]} stands in two rows; keep the pictures of one video")
    confidence = np.where(np.isnan(likelihood), CERTAIN, likelihood)  # labelled by hand
    return Track(frames[order], tuple(parts), image[order], confidence[order])


def choose(where: str, individuals: Sequence[str], wanted: str | None) -> str:
    """The individual wanted, or the only one. Raises ValueError that names those there are."""
    if wanted is None and len(individuals) <= 1:
        return individuals[0] if individuals else ""
    if wanted is not None and (wanted in individuals or list(individuals) in ([], [""])):
        return wanted if wanted in individuals else ""
    named = ", ".join(individuals)
    if wanted is None:
        raise ValueError(f"{where}: it has {named}: say who is whom by --demonstrator NAME and --learner NAME")
    raise ValueError(f"{where}: nobody is named {wanted!r}; it has {named}")


def frame_of(where: str, cells: Sequence[str]) -> int:
    """Its number, or the last number in the name of its picture. Raises ValueError."""
    text = cells[-1].strip().replace("\\", "/")
    if text.isdecimal() and int(text) <= MOST_FRAME:
        return int(text)
    digits = re.findall(r"\d+", PurePosixPath(text).stem)
    if not digits or not PurePosixPath(text).suffix or int(digits[-1]) > MOST_FRAME:
        raise ValueError(
            f"{where}: {text!r} is neither a whole number from 0 nor a picture named with one, img0003.png"
        )
    return int(digits[-1])
