"""Text with many numbers in it, all of which are put in their places at once."""

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FAR_OUT = 9_999  # tenths: few numbers of a drawing are larger
BYTE = np.uint64(8)  # bits


@cache
def _texts() -> NDArray:
    """(2 FAR_OUT + 1,) uint64: numbers with one decimal as bytes, filled up with 0 behind and by a byte for their lead
    before, by how many tenths they are, those below 0 counted from the end. 0 is written in one way."""
    counts = np.roll(np.arange(-FAR_OUT, FAR_OUT + 1), -FAR_OUT)
    return np.array([f"{count / 10:.1f}" for count in counts.tolist()], "S8").view("<u8") << BYTE


class Form(NamedTuple):
    """A form cut in pieces of eight bytes, filled up with 0, so that numbers are put in their places at once. places:
    (n,), of the numbers; leads: (n,), the byte before each."""

    pieces: NDArray
    places: NDArray
    leads: NDArray

    def written(self, texts: NDArray) -> str:
        """texts: (n,), of numbers with their leads."""
        pieces = self.pieces.copy()
        pieces[self.places] = texts
        return pieces.tobytes().translate(None, b"\0").decode()

    def texts(self, tenths: NDArray) -> NDArray:
        """Of so many tenths, (n,), at most FAR_OUT, each with its lead."""
        return _texts()[tenths.astype(np.intp)] | self.leads


@lru_cache(512)
def form_of(form: str) -> Form:
    """form: with %s where a number stands"""
    *before, last = [part.encode() for part in form.split("%s")]
    pieces, places = b"", []
    for part in before:
        pieces += _padded(part[:-1])
        places.append(len(pieces) // 8)
        pieces += _padded(part[-1:] or b"\0")
    leads = np.array([part[-1] if part else 0 for part in before], "<u8")
    return Form(np.frombuffer(pieces + _padded(last), "<u8"), np.array(places, np.intp), leads)


def _padded(text: bytes) -> bytes:
    return text + b"\0" * (-len(text) % 8)


def filled(form: str, values: NDArray) -> str:
    """A form with a number of one decimal in place of each %s. Texts of all numbers are taken from a table at once,
    which takes a quarter of what it takes to write hundreds of them one by one."""
    tenths = np.rint(values * 10).ravel()
    if not (np.abs(tenths) <= FAR_OUT).all():
        return form % tuple(f"{count / 10 + 0.0:.1f}" for count in tenths.tolist())
    known = form_of(form)
    return known.written(known.texts(tenths))
