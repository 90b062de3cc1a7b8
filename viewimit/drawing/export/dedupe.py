"""Drawings that differ in little, told once: the pieces that they have in common, and the way of each through them."""

import re
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Woven:
    """ways: of each drawing, which of the pieces follow each other."""

    pieces: list[str]
    ways: list[list[int]]

    def __getitem__(self, k: int) -> str:
        return "".join(self.pieces[i] for i in self.ways[k])


def weave(drawings: Sequence[str]) -> Woven:
    """HTML each."""
    cut = [re.split("(?=<)", drawing) for drawing in drawings]
    at = {piece: i for i, piece in enumerate(dict.fromkeys(piece for pieces in cut for piece in pieces))}
    return Woven(list(at), [[at[piece] for piece in pieces] for pieces in cut])
