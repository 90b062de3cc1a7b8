"""Record the golden runs anew: `python tests/golden/record.py`. It prints which runs have changed, and by how much.

Each run is played again from a start that is moved by the least that a session knows. One that this changes by more
than other processors may is named: choose another seed or start, fewer motions, or say why it may differ by more.

    --check   write nothing; exit status 1 if a run has changed
"""

import os
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is loaded: more threads only spin

from golden_runs import CLOSE, E_PER_RAD, RECORDING, RUNS, Run, Trace, difference, play, read, write

MOVED_DEG = (1e-9, -1e-9, 2e-9)  # a session rounds its start to 1e-9°


def sensitivity(run: Run, trace: Trace) -> str:
    """By how much a start that is moved changes a run by more than it may elsewhere; "" if none does."""
    for moved_deg in MOVED_DEG:
        found = difference(play(run, moved_deg), trace)
        if not found.within(run.elsewhere, E_PER_RAD * run.elsewhere):
            return f"start moved by {moved_deg:g}°: {found}"
    return ""


def main(words: list[str]) -> int:
    """Exit status."""
    check = "--check" in words
    old, same = read() if RECORDING.exists() else ({}, True)
    if not same:
        print("It was recorded where numbers are rounded otherwise: small differences are of the processor.")
    new: dict[str, Trace] = {}
    changed, began = list(old.keys() - {run.name for run in RUNS}), time.process_time()
    for name in changed:
        print(f"{name}: gone")
    for run in RUNS:
        trace = new[run.name] = play(run)
        ended = f"{trace.status[-1]} after {len(trace.E) - 1} motions"
        if run.name not in old:
            changed.append(run.name)
            print(f"{run.name}: new, {ended}")
        elif not (found := difference(trace, old[run.name])).within(CLOSE, CLOSE):
            changed.append(run.name)
            print(f"{run.name}: {found}; now {ended}")
        if moves := sensitivity(run, trace):
            print(f"{run.name}: TOO SENSITIVE to be compared elsewhere; {moves}")
    print(f"{len(changed)} of {len(RUNS)} runs changed; {time.process_time() - began:.0f} s of processor time")
    if check:
        return int(bool(changed))
    write(new)
    print(f"{RECORDING.name}: {RECORDING.stat().st_size:,} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
