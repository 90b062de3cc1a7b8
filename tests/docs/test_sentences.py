"""The documentation is written in short sentences."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
MAX_WORDS, MAX_SHARE = 30, 0.05
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NO_PROSE = (
    (re.compile(r"^(```|:::)[^\n]*\n.*?^\1 *$", re.S | re.M), "\n\n"),  # code and directives
    (re.compile(r"\$\$.*?\$\$|\$[^$\n]+\$", re.S), "x"),
    (re.compile(r"`[^`]+`"), "x"),
    (re.compile(r"!?\[([^\]]*)\]\([^)]*\)"), r"\1"),
)
ITEM = re.compile(r"\s*(?:[-*]|\d+\.|#+)\s")
END = re.compile(r"(?<=[.!?:])[\"”)*]*\s+(?=[A-Z“\"(*])")
WORD = re.compile(r"[^\W\d_][\w'’.-]*|\d[\d.,]*")


def paragraphs(text):
    """Paragraphs, items of lists, headings and cells of tables."""
    for pattern, by in NO_PROSE:
        text = pattern.sub(by, text)
    for block in re.split(r"\n\s*\n", text):
        found = [""]
        for line in block.splitlines():
            if line.lstrip().startswith("|"):
                found += line.strip().strip("|").split("|")
            elif ITEM.match(line):
                found.append(ITEM.sub("", line, count=1))
            else:
                found[-1] += " " + line
        yield from found


def lengths(path):
    """Words of each sentence of a page."""
    sentences = (one for text in paragraphs(path.read_text("utf-8")) for one in END.split(text))
    return [(len(words), sentence) for sentence in sentences if len(words := WORD.findall(sentence)) > 2]


def test_sentences_are_split_where_they_end():
    text = "One is short. Two has (a list):\n\n- an item of five words\n- `code` and $x$ too.\n\n| a b c | d e f |\n"
    found = [sentence.strip() for part in paragraphs(text) for sentence in END.split(part) if sentence.strip()]
    assert found == ["One is short.", "Two has (a list):", "an item of five words", "x and x too.", "a b c", "d e f"]


def test_few_sentences_are_long():
    found = {path: lengths(path) for path in PAGES}
    long = [
        (count, path.name, text.strip()) for path, all_ in found.items() for count, text in all_ if count > MAX_WORDS
    ]
    assert len(long) < MAX_SHARE * sum(map(len, found.values())), "\n".join(map(str, sorted(long, reverse=True)))
