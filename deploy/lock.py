"""Writes requirements.lock: what pip takes for this project now, by version and SHA-256, with no address of an index.

python3.11 deploy/lock.py    # CPython 3.11 on Linux x86-64, as the image has it; elsewhere pip would take other files
"""

import json
import platform
import subprocess
import sys
from pathlib import Path

import tomllib

HERE = Path(__file__).parent
HEADING = "# Made by deploy/lock.py for CPython 3.11 on Linux x86-64: pip install --require-hashes -r with this file\n"


def main() -> None:
    here = platform.python_implementation(), sys.version_info[:2], sys.platform, platform.machine()
    if here != ("CPython", (3, 11), "linux", "x86_64"):
        raise SystemExit(f"lock.py: needs CPython 3.11 on Linux x86-64, this is {here}")
    said = tomllib.loads((HERE.parent / "pyproject.toml").read_text())
    found = taken([*said["build-system"]["requires"], *said["project"]["dependencies"]])
    lines = (f"{pinned} --hash=sha256:{digest}\n" for pinned, digest in sorted(found.items()))
    (HERE / "requirements.lock").write_text(HEADING + "".join(lines))


def taken(requirements: list[str]) -> dict[str, str]:
    """What pip would install: SHA-256 of the wheel by name==version. Nothing is installed."""
    options = "--dry-run", "--ignore-installed", "--only-binary=:all:", "--quiet", "--report", "-"
    command = [sys.executable, "-m", "pip", "install", *options, *requirements]
    report = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    return {
        f"{one['metadata']['name'].lower()}=={one['metadata']['version']}": one["download_info"]["archive_info"][
            "hashes"
        ]["sha256"]
        for one in report["install"]
    }


if __name__ == "__main__":
    main()
