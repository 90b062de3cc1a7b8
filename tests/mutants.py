"""Make each fault of tests/mutants.toml, run the test that is to notice it, undo it: `python tests/mutants.py [WORD]`

Prints a table, of those whose file has the word in its path. Exit status 1 if a test passes in spite of a fault.

    --check   make none: only look whether each text stands once in its file, and whether its test exists
"""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

TESTS = Path(__file__).parent
ROOT = TESTS.parent


class Mutant(NamedTuple):
    """A fault: the text of a file that another replaces, and the test that fails then."""

    file: str
    text: str
    replacement: str
    tests: str
    test: str


def mutants(word: str = "") -> Iterator[Mutant]:
    """Yield the faults in files whose path has this word."""
    for group in tomllib.loads((TESTS / "mutants.toml").read_text("utf-8"))["group"]:
        if word in group["file"]:
            for text, replacement, test in group["mutants"]:
                yield Mutant(group["file"], text, replacement, group["tests"], test)


def fault_in(mutant: Mutant) -> str:
    """Return why a fault cannot be made any more; "" if it can."""
    count = (ROOT / mutant.file).read_text("utf-8").count(mutant.text)
    if count != 1:
        return f"{mutant.file} has {mutant.text!r} {count} times"
    if f"def {mutant.test}(" not in (TESTS / mutant.tests).read_text("utf-8"):
        return f"tests/{mutant.tests} has no {mutant.test}"
    return ""


def is_noticed(mutant: Mutant) -> bool:
    """Make the fault, run its test, and restore the file to its bytes and time, so that no stale bytecode is used."""
    path = ROOT / mutant.file
    content, times = path.read_bytes(), path.stat()
    words = ("-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist", f"tests/{mutant.tests}::{mutant.test}")
    try:
        path.write_bytes(content.replace(mutant.text.encode(), mutant.replacement.encode()))
        done = subprocess.run([sys.executable, "-m", "pytest", *words], cwd=ROOT, capture_output=True, text=True)
    finally:
        path.write_bytes(content)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    if done.returncode not in (0, 1):  # not collected, or stopped
        raise RuntimeError(f"{mutant.test}: {done.stdout[-2_000:]}{done.stderr[-2_000:]}")
    return done.returncode == 1


def main(words: list[str]) -> int:
    """Return the exit status."""
    check = "--check" in words
    chosen = list(mutants(*[word for word in words if word != "--check"][:1]))
    if faults := [fault for mutant in chosen if (fault := fault_in(mutant))]:
        print(*faults, sep="\n")
        return 1
    if check:
        return 0
    missed, began = 0, time.monotonic()
    for mutant in chosen:
        noticed = is_noticed(mutant)
        missed += not noticed
        print(f"{'noticed' if noticed else 'MISSED '}  {mutant.file}: {mutant.text!r}  by {mutant.test}", flush=True)
    print(f"{len(chosen) - missed} of {len(chosen)} are noticed; {time.monotonic() - began:.0f} s")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
