"""The files for a public forge, a documentation host and pre-commit are valid and say what the project says."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

yaml = pytest.importorskip("yaml")

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
SCHEMAS = {
    **{path: "github-workflows" for path in WORKFLOWS},
    ROOT / ".readthedocs.yaml": "readthedocs",
    ROOT / "CITATION.cff": "citation-file-format",
}
VERSIONS = [
    found[1]
    for classifier in PROJECT["project"]["classifiers"]
    if (found := re.fullmatch(r"Programming Language :: Python :: (3\.\d+)", classifier))
]


def read(path):
    return yaml.safe_load((ROOT / path).read_text("utf-8"))


def commands(path):
    """All that a workflow runs."""
    return [step["run"] for job in read(path)["jobs"].values() for step in job["steps"] if "run" in step]


@pytest.mark.parametrize("path", SCHEMAS, ids=lambda path: path.name)
def test_a_file_matches_its_schema(path):
    pytest.importorskip("check_jsonschema")
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{SCHEMAS[path]}", str(path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_supported_python_is_tested_on_every_system():
    matrix = read(".github/workflows/tests.yml")["jobs"]["everywhere"]["strategy"]["matrix"]
    assert matrix["python"] == VERSIONS and f">={VERSIONS[0]}" == PROJECT["project"]["requires-python"]
    assert {name.partition("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}
    assert f"for version in {' '.join(VERSIONS)}; do" in (ROOT / ".ci/run").read_text()


def test_what_is_run_exists():
    said = " ".join(line for path in WORKFLOWS for line in commands(path))
    assert "bash .ci/run" in said and "@tests/portable.txt" in said
    assert "@tests/portable.txt" in (ROOT / ".ci/run").read_text()
    listed = (ROOT / "tests/portable.txt").read_text().splitlines()
    files = [line for line in listed if line.startswith("tests/")]
    assert len(files) > 8 and all((ROOT / file).is_file() for file in files)
    groups = set(re.findall(r"--group (\w+)", said + (ROOT / ".readthedocs.yaml").read_text()))
    assert groups == {"lint", "docs"} and groups <= PROJECT["dependency-groups"].keys()


def test_the_host_builds_the_documentation():
    host = read(".readthedocs.yaml")
    assert any("docs/build.py" in line for line in host["build"]["commands"])
    assert host["build"]["tools"]["python"] in VERSIONS


def test_actions_and_hooks_are_pinned():
    """Actions by their commit; hooks by pyproject.toml, as they are the tools that are installed."""
    uses = [
        step["uses"]
        for path in WORKFLOWS
        for job in read(path)["jobs"].values()
        for step in job["steps"]
        if "uses" in step
    ]
    assert uses and all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", name) for name in uses)
    (local,) = read(".pre-commit-config.yaml")["repos"]
    tools = {hook["entry"].split()[2 if hook["entry"].startswith("python -m") else 0] for hook in local["hooks"]}
    assert local["repo"] == "local" and {hook["language"] for hook in local["hooks"]} == {"system"}
    lint = {re.match(r"[\w-]+", need)[0] for need in PROJECT["dependency-groups"]["lint"]}
    assert tools <= lint
    schemas = {word for hook in local["hooks"] for word in hook["entry"].split() if word.startswith("vendor.")}
    assert schemas == {f"vendor.{name}" for name in SCHEMAS.values()}
    for path in SCHEMAS:
        place = path.relative_to(ROOT).as_posix()
        assert any(re.search(hook["files"], place) for hook in local["hooks"] if "files" in hook), place


@pytest.mark.parametrize("name", ["CONTRIBUTING.md", "SECURITY.md"])
def test_what_a_page_for_contributors_names_exists(name):
    text = (ROOT / name).read_text("utf-8")
    for link in re.findall(r"\]\(([^)]+)\)", text):
        assert (ROOT / link).is_file(), link
    for path in re.findall(r"(?<![\w/.])(?:tests|docs|viewimit|deploy|\.github)/[\w./-]+", text):
        assert (ROOT / path.rstrip(".")).exists(), path
