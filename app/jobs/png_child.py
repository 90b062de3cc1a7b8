"""What makes a PNG of an SVG in a process of its own, as it would hold up all pages here: from its standard input to
its standard output."""

import subprocess
import sys

from .child import stand_back

NICENESS, WITHIN = 5, 60.0  # WITHIN: s


def render(picture: str) -> bytes:
    """A standalone SVG as PNG, at print size; it blocks. Raises ValueError if that fails."""
    try:
        made = subprocess.run(
            [sys.executable, "-m", __name__], input=picture.encode(), capture_output=True, timeout=WITHIN
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"the PNG took longer than {WITHIN:g} s; save it as SVG") from None
    if made.returncode:
        raise ValueError("the PNG could not be made; save it as SVG")
    return made.stdout


if __name__ == "__main__":
    stand_back(NICENESS)
    from viewimit.drawing.export.figures import as_png

    sys.stdout.buffer.write(as_png(sys.stdin.buffer.read().decode()))
