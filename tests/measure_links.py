"""How many random sessions of ten changes come back bit for bit as links, in a page and by the command line.

PYTHONPATH=tests python tests/measure_links.py    # --sessions 200 --seed 1
"""

import argparse
import contextlib
import io
import random
import tempfile
from pathlib import Path

import numpy as np
from page_fakes import Hands
from quiet_page import QuietPage
from sameness import assert_same
from viewimit.app.model.keeping import SEND_EVERY, share_link

from viewimit.commands.cli import main as command
from viewimit.loop.settings import Settings

CHANGES = 10
ACTS = {
    "step": [1, 2, 3],
    "undo": [1, 2],
    "reset": [1],
    "joint0": [50.0, 55.5, 61.0, 44.5],
    "history": [0, 1, 2],
    "preset": ["Noisy pictures", "Five points", "Seven joints"],
    "servo": ["Broyden’s rule", "Kalman filter"],
    "noise_px": [0.25, 1.0],
    "rehearsal": [1],
}


def visited(rng: random.Random) -> QuietPage:
    """A page in which as many changes were made as are possible there."""
    page, made = begun(), 0
    hands = Hands(page.page.model)
    while made < CHANGES:
        what = rng.choice(list(ACTS))
        value = rng.choice(ACTS[what])
        with contextlib.suppress(ValueError, KeyError, StopIteration):  # what cannot be here
            for _ in range(value if what in ("step", "undo") else 1):
                hands.act(what) if what in ("step", "undo", "reset", "rehearsal") else hands.set(what, value)
                hands.model.player.pause()
            made += 1
        page.tick(SEND_EVERY)
    return page


def begun(kept: str = "") -> QuietPage:
    page = QuietPage(Settings.paper())
    page.restore(kept)
    return page


def comes_back_in_a_page(page: QuietPage) -> bool:
    one, other = page.page.model.session, begun(page.kept).page.model.session
    return _is_same(tuple(one.history), tuple(other.history)) and one.cursor == other.cursor


def comes_back_by_the_command(page: QuietPage, folder: Path) -> bool:
    out, session = folder / "run.npz", page.page.model.session
    words = ["imitate", "--link", share_link(page.page.model), "--max-motions", "0", "--out", str(out)]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        command(words)
    with np.load(out) as found:
        shown = session.cursor + 1
        return all(np.array_equal(values[:shown], found[name], equal_nan=values.dtype.kind == "f")
                   for name, values in session.history.arrays().items())  # fmt: skip


def _is_same(one: tuple, other: tuple) -> bool:
    try:
        assert_same(one, other)
    except AssertionError:
        return False
    return True


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    rng, back, longest = random.Random(args.seed), [0, 0], 0
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(args.sessions):
            page = visited(rng)
            back[0] += comes_back_in_a_page(page)
            back[1] += comes_back_by_the_command(page, Path(folder))
            longest = max(longest, len(share_link(page.page.model)))
    print(f"of {args.sessions} sessions of {CHANGES} changes came back bit for bit:")
    print(f"{back[0]} in a page, {back[1]} by the command line; the longest link has {longest} characters")


if __name__ == "__main__":
    main()
