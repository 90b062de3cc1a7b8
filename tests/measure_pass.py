"""What one pass of the loop enters: files of viewimit/, functions, calls, and frames below `Session.step`.

python tests/measure_pass.py    # --servo NAME, --noise PX, --motion K; --files names the files
"""

import argparse
import sys
from collections import Counter
from pathlib import Path

from viewimit import Session, Settings

PACKAGE = str(Path(__file__).parent.parent / "viewimit") + "/"


class Pass:
    """Counts the calls of functions of viewimit/ inside, by file and name, and how deep they are nested."""

    def __init__(self):
        self.calls: Counter[tuple[str, str]] = Counter()
        self.depth = self._now = 0

    def __enter__(self):
        sys.setprofile(self._enter)
        return self

    def __exit__(self, *_):
        sys.setprofile(None)

    def _enter(self, frame, event, _):
        code = frame.f_code
        if event in ("call", "return") and code.co_filename.startswith(PACKAGE):
            self._now += 1 if event == "call" else -1
            self.depth = max(self.depth, self._now)
            if event == "call":
                self.calls[code.co_filename[len(PACKAGE) :], code.co_qualname] += 1

    @property
    def files(self) -> Counter[str]:
        """Functions that were entered in each file."""
        return Counter(file for file, _ in self.calls)


def measure(settings: Settings, motion: int) -> Pass:
    """Follow the pass that makes this motion, counted from 1."""
    session = Session(settings)
    session.run(motion - 1)
    with Pass() as found:
        session.step()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--servo", default=Settings().servo)
    parser.add_argument("--noise", type=float, default=0.0, help="px")
    parser.add_argument("--motion", type=int, default=3, help="which motion of the run")
    parser.add_argument("--files", action="store_true")
    asked = parser.parse_args()
    found = measure(Settings(servo=asked.servo, noise_px=asked.noise), asked.motion)
    calls = sum(found.calls.values())
    print(f"{len(found.files)} files, {len(found.calls)} functions, {calls} calls, {found.depth} frames deep")
    for file, count in sorted(found.files.items()) if asked.files else ():
        print(f"{count:5}  {file}")


if __name__ == "__main__":
    main()
