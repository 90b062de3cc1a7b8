"""README and docs say what is: commands print what README shows, lines are those that run, links lead somewhere. The
documentation's own examples are executed when it is built: tests/docs/test_site.py."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from viewimit.commands.cli import main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.DOTALL | re.MULTILINE)


def examples():
    """(words, output shown) of each `$ viewimit …` line."""
    (console,) = blocks("console")
    for example in console.split("$ viewimit ")[1:]:
        words, _, output = example.partition("\n")
        yield shlex.split(words), output


@pytest.mark.parametrize("words, shown", list(examples()), ids=lambda value: value[0])
def test_commands_print_what_readme_shows(words, shown, capsys):
    assert main(words) == (1 if ", settled" in shown else 0)  # as what is printed says
    assert capsys.readouterr().out == shown


DOCS = "".join(path.read_text("utf-8") for path in (ROOT / "docs").rglob("*") if path.suffix in (".md", ".toml"))
PROGRAMS = sorted(set(re.findall(r"[`\"]python (-m viewimit[\w.]+|tests/\w+\.py)", README + DOCS)))


@pytest.mark.parametrize("program", PROGRAMS)
def test_programs_that_are_named_run(program):
    command = [sys.executable, *program.split(), "--help"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_the_example_of_the_library_runs_and_prints_its_comments(capsys):
    (code,) = blocks("python")
    exec(compile(code, "README.md", "exec"), {})
    expected = re.findall(r"^print.*  # (.*)$", code, re.MULTILINE)
    assert len(expected) == 1
    assert capsys.readouterr().out.splitlines() == expected
    assert sum(bool(line.strip()) for line in code.splitlines()) <= 12  # ten lines, and two of imports


def test_there_are_two_lines_and_ci_runs_the_second():
    opens, tests = (block.rstrip("\n") for block in blocks("sh"))
    assert "\n" not in opens + tests
    assert opens.endswith("/viewimit --open") and "pip install -e ." in opens
    assert "pip install -e . --group docs --group test" in tests and "tests/browser.py" in tests
    assert tests.endswith("-m pytest -n auto")
    script = (ROOT / ".ci/run").read_text()
    (extraction,) = re.findall(r"^test_line=\$\((.*)\)$", script, re.MULTILINE)
    found = subprocess.run(["bash", "-c", extraction], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert found.rstrip("\n") == tests
    assert 'bash -euc "$test_line"' in script and "VIEWIMIT_REQUIRE_BROWSER=1" in script


def test_links_lead_somewhere():
    prose = re.sub(r"^```.*?^```", "", README, flags=re.DOTALL | re.MULTILINE)
    links = re.findall(r"\]\(([^)]+)\)", prose)
    assert len(links) > 4
    for link in links:
        assert link.startswith("https://") or (ROOT / link).is_file(), link
