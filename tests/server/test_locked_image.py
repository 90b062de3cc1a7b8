"""What the image installs: pinned by hash, all that is asked for, and from wherever an index is."""

import re
import subprocess
import sys
import venv
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

tomllib = pytest.importorskip("tomllib")  # from Python 3.11 on, as in the image

ROOT = Path(__file__).parents[2]
LOCK = ROOT / "deploy/requirements.lock"
IMAGE = default_environment() | {
    "python_version": "3.11", "python_full_version": "3.11.0", "implementation_name": "cpython",
    "platform_python_implementation": "CPython", "sys_platform": "linux", "platform_system": "Linux",
    "platform_machine": "x86_64", "os_name": "posix", "extra": "",
}  # fmt: skip
PINNED = re.compile(r"([\w.-]+)==([\w.+!]+) --hash=sha256:([0-9a-f]{64})")


def pinned() -> dict[str, str]:
    """Versions by package. Every line is one, with its hash, and nothing else."""
    lines = [line for line in LOCK.read_text().splitlines() if not line.startswith("#")]
    found = [PINNED.fullmatch(line) for line in lines]
    assert lines and all(found), [line for line, match in zip(lines, found) if not match]
    versions = {canonicalize_name(match[1]): match[2] for match in found}
    assert len(versions) == len(lines)
    return versions


def test_all_that_the_project_asks_for_is_pinned():
    said, versions = tomllib.loads((ROOT / "pyproject.toml").read_text()), pinned()
    for requirement in map(Requirement, [*said["build-system"]["requires"], *said["project"]["dependencies"]]):
        if requirement.marker is None or requirement.marker.evaluate(IMAGE):
            assert requirement.specifier.contains(versions[canonicalize_name(requirement.name)]), requirement


def steps() -> list[str]:
    return re.findall(r"^RUN (pip install .*?)(?: &&|$)", (ROOT / "Dockerfile").read_text(), re.MULTILINE)


def test_the_image_installs_by_hash_what_it_copies():
    text = (ROOT / "Dockerfile").read_text()
    copied = [word for line in re.findall(r"^COPY (.*)$", text, re.MULTILINE) for word in line.split()[:-1]]
    assert all((ROOT / word).exists() for word in copied) and "deploy/requirements.lock" in copied
    assert len(steps()) == 2 and "--require-hashes" in steps()[0] and "--no-deps" in steps()[1]


def test_every_image_that_others_made_is_pinned():
    named = re.findall(r"^FROM (?:--\S+ )*(\S+)", (ROOT / "Dockerfile").read_text(), re.MULTILINE)
    named += re.findall(r"^ +image: (\S+)", (ROOT / "compose.yaml").read_text(), re.MULTILINE)
    assert len(named) == 2 and all(re.fullmatch(r"[\w./-]+:[\w.-]+@sha256:[0-9a-f]{64}", image) for image in named), (
        named
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.version_info[:2] != (3, 11) or sys.platform != "linux", reason="the lock is of another system")
def test_the_steps_of_the_image_install_the_command(tmp_path):
    venv.create(tmp_path / "image", with_pip=True)
    for step in steps():
        done = subprocess.run(
            [tmp_path / "image/bin/python", "-m", *step.split()], cwd=ROOT, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
    told = subprocess.run([tmp_path / "image/bin/viewimit", "--version"], capture_output=True, text=True)
    assert re.search(r"^viewimit \d", told.stdout)
