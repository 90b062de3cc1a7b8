"""Builds the documentation: python docs/build.py FOLDER. Every example in it is executed; one that fails ends it.

It needs `pip install -e . --group docs`, of pip 25.1 or newer. `viewimit site DIR` builds it with the lab and the
lessons, to which it links, beside it.
"""

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from sphinx.cmd.build import build_main

HERE = Path(__file__).parent


def build(folder: Path) -> int:
    """Into a folder, whose former contents are lost → Sphinx's exit status."""
    shutil.rmtree(folder, ignore_errors=True)
    with TemporaryDirectory() as kept:
        status = build_main(["-q", "-E", "-W", "--keep-going", "-b", "html", "-d", kept, str(HERE), str(folder)])
    (folder / ".buildinfo").unlink(missing_ok=True)
    return status


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("python docs/build.py FOLDER")
    sys.exit(build(Path(sys.argv[1]).resolve()))
