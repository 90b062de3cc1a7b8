"""Builds the documentation: python docs/build.py [FOLDER]. Every example in it is executed; one that fails ends it.

The lab is written beside it, lab.html.

It needs `pip install -e . --group docs`, of pip 25.1 or newer. Without a folder it goes to build/site, where
`viewimit docs` finds it.
"""

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from sphinx.cmd.build import build_main
from viewimit.app.lab.page import lab_page

HERE = Path(__file__).parent
NEEDLESS = (".buildinfo",)


def build(folder: Path) -> int:
    """Into a folder, whose former contents are lost → Sphinx's exit status."""
    shutil.rmtree(folder, ignore_errors=True)
    with TemporaryDirectory() as kept:
        status = build_main(["-q", "-E", "-W", "--keep-going", "-b", "html", "-d", kept, str(HERE), str(folder)])
    for name in NEEDLESS:
        (folder / name).unlink(missing_ok=True)
    shutil.rmtree(folder / "_sources", ignore_errors=True)
    if not status:
        folder.joinpath("lab.html").write_text(lab_page(), "utf-8")
    return status


if __name__ == "__main__":
    asked = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent / "build" / "site"
    ended = build(asked.resolve())
    if not ended:
        print(f"the documentation begins at {asked.resolve() / 'index.html'}")
    sys.exit(ended)
