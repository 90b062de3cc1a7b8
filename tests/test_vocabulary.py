"""Names and texts of the library use words that a reader can look up: earlier private words do not come back."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
# Words that were private to this project: each has a term of the field or a plain word in its place
PRIVATE = """anew astray deed deeds disobeyed erelong foresee foreseen foresees foretell foretells heed heeded heeds
hitherto learnable lest onwards puzzled strayed surroundings therein thereof told untold untried whichever
whoever""".split()
# Earlier names of classes, functions and constants
FORMER = """BodyImage MinimalServo Outlook TrustState Surroundings beyond_rank half_seen look_out likely_exchange
with_exchanged with_half_seen""".split()
TEXTS = sorted(
    path
    for folder in ("viewimit", "docs")
    for path in (ROOT / folder).rglob("*")
    if path.suffix in (".py", ".md", ".js", ".css", ".html")
) + [ROOT / "README.md"]
READ = {  # earlier words that files and links of users may have, and that are still read
    "viewimit/servo/status.py": {"untold"},
    "viewimit/loop/script.py": {"deeds"},
    "docs/reference/json.md": {"told", "untold"},
}
RENAMED = ROOT / "viewimit/sensing/renamed.py"


def words_of(text):
    """Words of a text, and of its snake_case and CamelCase names, in lower case."""
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", text)}


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_private_words_do_not_come_back(path):
    text = path.read_text("utf-8")
    assert not words_of(text) & set(PRIVATE) - READ.get(path.relative_to(ROOT).as_posix(), set())
    if path != RENAMED:
        assert not set(re.findall(r"\w+", text)) & set(FORMER)
