"""Writes the lock files: what pip takes for this project now, by version and SHA-256, with no address of an index.

python3.11 deploy/lock.py    # CPython 3.11 on Linux x86-64, as the image has it; elsewhere pip would take other files
"""

import json
import platform
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import tomllib

HERE = Path(__file__).parent
# with these dependency groups
LOCKS: dict[str, tuple[str, ...]] = {"requirements.lock": (), "requirements-test.lock": ("docs", "test")}
HEADING = "# Made by deploy/lock.py for CPython 3.11 on Linux x86-64: pip install --require-hashes -r deploy/{name}\n"


def main() -> None:
    here = platform.python_implementation(), sys.version_info[:2], sys.platform, platform.machine()
    if here != ("CPython", (3, 11), "linux", "x86_64"):
        raise SystemExit(f"lock.py: needs CPython 3.11 on Linux x86-64, this is {here}")
    found: dict[str, str] = {}  # SHA-256 by name and version, which the next file takes over
    for name, groups in LOCKS.items():
        found = taken([*asked(groups), *found])
        lines = (f"{pinned} --hash=sha256:{digest}\n" for pinned, digest in sorted(found.items()))
        (HERE / name).write_text(HEADING.format(name=name) + "".join(lines))


def asked(groups: tuple[str, ...]) -> list[str]:
    """What the project needs to be built and to run, with these dependency groups."""
    said = tomllib.loads((HERE.parent / "pyproject.toml").read_text())
    more = [requirement for group in groups for requirement in of_group(said["dependency-groups"], group)]
    return [*said["build-system"]["requires"], *said["project"]["dependencies"], *more]


def of_group(groups: dict[str, list], name: str) -> Iterator[str]:
    """Requirements of a dependency group (PEP 735), and of those that it includes."""
    for item in groups[name]:
        if isinstance(item, str):
            yield item
        else:
            yield from of_group(groups, item["include-group"])


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
