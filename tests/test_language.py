"""Texts that people see are translated: all are marked and in the catalog, and the page speaks another language."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
CATALOG = ROOT / "assets" / "locale" / "viewimit.pot"
SOURCES = sorted(path for folder in ("viewimit", "app") for path in (ROOT / folder).rglob("*.py"))
OF_DATA = (ROOT / "viewimit" / "drawing" / "glossary.py", ROOT / "app" / "static" / "__init__.py")
TRANSLATED = [path for path in SOURCES if "language import" in path.read_text("utf-8")]
MARKS = ("_", "ngettext")


@pytest.mark.parametrize("path", TRANSLATED, ids=lambda path: path.stem)
def test_nothing_hides_the_translator(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        assigned = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id == "_"
        defined = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name == "_"
        assert not assigned and not defined, node.lineno
        assert not (isinstance(node, ast.arg) and node.arg == "_"), node.lineno


@pytest.mark.parametrize("path", TRANSLATED, ids=lambda path: path.stem)
def test_marked_texts_are_literals(path):
    """What is not written in the code is not in the catalog, but for texts that are read from files."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in MARKS:
            texts = node.args[:2] if node.func.id == "ngettext" else node.args
            assert path in OF_DATA or all(isinstance(text, ast.Constant) for text in texts), node.lineno


def test_the_catalog_is_up_to_date():
    pytest.importorskip("babel")
    from viewimit.assets.build_catalog import template

    assert template() == CATALOG.read_text("utf-8"), "run python -m viewimit.assets.build_catalog"


# No visible literal stands outside the catalog. A literal is visible if it reads as words, outside of tags or in an
# attribute that is read aloud: two words or a field and a word, or a word with a capital letter.

PAGE = (
    *(
        f"app/{room}"
        for room in ("commands", "drawing", "jobs", "model", "page", "panels", "scene", "sessions", "static")
    ),
    "viewimit/drawing",
    "viewimit/experiments/paper",
    "viewimit/servo/registry.py",
    "viewimit/servo/status.py",
    "viewimit/servo/trust_region/explanation.py",
    "viewimit/estimation/transfers/registry.py",
)
FIELD = "\0"  # stands for a field of an f-string
TAG = re.compile(r"<[^>]*>|&\w+;")
SPOKEN = re.compile(r'(?:aria-label|title|alt|placeholder)="([^"]*)"')
STYLE = re.compile(r"[;{}]|--")  # of CSS
WORDS = re.compile(rf"(?:(?<![\w-])[A-Za-z]{{2,}}[,;:.]? |{FIELD} )[a-z]{{2,}}(?![\w-])|^\s*[A-Z][a-z]+(?![\w-])")
UNSEEN_CALLS = {"TypeVar", "log", "Tolerance"}  # whose texts nobody sees on the page
EXCEPTIONS = (  # beginnings of texts that are the same in every language, or that only programmers see
    "two commands named", f"command {FIELD}: {FIELD} needs", f", and {FIELD} more since the line before",
    "a transfer needs points", "a transfer is a function", f"the servo {FIELD} has no", " and no ",
    f"give {FIELD} to ServoMethod", "step(state", "#set document", "pip install", "“View-Based", "<kbd>", "<math ",
    "Inter,", "Fig. 10: ", "all points, transfer", "the hand's points, transfer",  # fonts; keys of Fig. 10
)  # fmt: skip
SAME = {  # whole texts of that kind
    "Inter", "Regular", "Minus", "Fig.", f"{FIELD} px",
    "Images",  # a key of `model.pictures.PICTURES`
    "all points", "same posture", "minimum on pictures", "E at rest",  # keys of Figs. 8 to 10
}  # fmt: skip


def whole(node):
    """The text of a literal, with FIELD in place of fields."""
    if isinstance(node, ast.Constant):
        return node.value
    return "".join(part.value if isinstance(part, ast.Constant) else FIELD for part in node.values)


def is_visible(text):
    said = [re.sub(" +", " ", TAG.sub(" ", text)), *SPOKEN.findall(text)]
    return any(WORDS.search(words) and not STYLE.search(words) for words in said)


def unseen(tree):
    """Nodes of marked texts and of what nobody reads: docstrings, keys, annotations, what a value is compared with."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            called = node.func.value if isinstance(node.func, ast.Attribute) else node.func
            if isinstance(called, ast.Name) and called.id in {*MARKS, *UNSEEN_CALLS}:
                yield from node.args
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield node.value
        elif isinstance(node, ast.Dict):
            yield from filter(None, node.keys)
        elif isinstance(node, ast.Subscript):
            yield node.slice
        elif isinstance(node, ast.AnnAssign | ast.arg):
            yield node.annotation
        elif isinstance(node, ast.FunctionDef):
            yield node.returns
        elif isinstance(node, ast.Compare):
            yield from node.comparators


def literals(node, skipped):
    """Texts below a node, f-strings as a whole."""
    if node in skipped and not isinstance(node, ast.Call | ast.Name):
        return
    if isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str)):
        yield node
    for child in ast.iter_child_nodes(node):
        if not (isinstance(node, ast.JoinedStr) and isinstance(child, ast.Constant)):
            yield from literals(child, skipped)


def visible_literals(code):
    tree = ast.parse(code)
    skipped = set(unseen(tree))
    for node in literals(tree, skipped):
        text = whole(node)
        if is_visible(text) and text not in SAME and not text.startswith(EXCEPTIONS):
            yield node.lineno, text.replace(FIELD, "{}")


@pytest.mark.parametrize("place", PAGE)
def test_no_visible_literal_stands_outside_the_catalog(place):
    path = ROOT / place
    for source in [path] if path.is_file() else sorted(path.rglob("*.py")):
        found = list(visible_literals(source.read_text("utf-8")))
        assert not found, f"{source.relative_to(ROOT)}: mark these by _() or ngettext(): {found}"


@pytest.mark.parametrize(
    "code",
    [
        'gui.add_button("Play")',
        'say(f"{n} points")',
        "f'<b>{n}</b> joints move'",
        "f'<i aria-label=\"What is {name}?\">{mark}</i>'",
        'raise ValueError("there is no duel")',
        "show(f\"{_('Start')} here\")",
    ],
)
def test_the_rule_sees_texts(code):
    assert list(visible_literals(code))


@pytest.mark.parametrize(
    "code",
    ['_("Play")', 'f"vi-at-{view}"', 'f\'<path class="vi-e" d="{d}"/>\'', "f'<b>{_(\"Play\")}</b>'", 'f"M{x} {y}h0"'],
)
def test_the_rule_leaves_marked_texts_and_markup(code):
    assert not list(visible_literals(code))


SENTENCE = re.compile(r"[\"`](?:• )?[A-Z][\w’']*,? [a-z“{]")
SETTERS = re.compile(r'(?:textContent\s*[=:]|"aria-label",|setCustomValidity\(|\.title\s*=)\s*["`][^"`]*[A-Za-z]')
STRING = re.compile(r'(_\()?("(?:[^"\\\n]|\\.)*"|`[^`]*`)')


def test_no_visible_literal_of_the_script_stands_outside_the_catalog():
    for path in sorted((ROOT / "app" / "static").glob("*.js")):
        for number, line in enumerate(path.read_text("utf-8").split("\n"), 1):
            code = re.sub(r"(?:^|\s)//.*|^\s*/?\*.*|\$\{[^}]*\}", "", line)  # without comments and fields
            texts = [text for mark, text in STRING.findall(code) if not mark and SENTENCE.match(text)]
            assert not texts and not SETTERS.search(code), f"{path.name}:{number}: mark by _(): {line.strip()}"


# A pseudo-language, each of whose texts is English in brackets


@pytest.fixture(scope="module")
def pseudo_language(tmp_path_factory):
    pofile = pytest.importorskip("babel.messages.pofile")
    from babel.messages.mofile import write_mo

    folder = tmp_path_factory.mktemp("locale")
    messages = folder / "de" / "LC_MESSAGES"  # a language with one plural, as English has
    messages.mkdir(parents=True)
    with CATALOG.open("rb") as file:
        catalog = pofile.read_po(file, locale="de")
    for message in catalog:
        if message.id:
            plural = isinstance(message.id, tuple)
            message.string = tuple(f"⟦{form}⟧" for form in message.id) if plural else f"⟦{message.id}⟧"
    with (messages / "viewimit.mo").open("wb") as file:
        write_mo(file, catalog)
    return os.environ | {"VIEWIMIT_LOCALE": str(folder), "LANGUAGE": "de", "PYTHONIOENCODING": "utf-8"}


def test_the_page_speaks_another_language_and_nothing_else(pseudo_language):
    command = [sys.executable, str(ROOT / "tests" / "pseudo_language.py")]
    ran = subprocess.run(command, capture_output=True, encoding="utf-8", env=pseudo_language)
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_the_page_speaks_english_without_a_catalog_of_the_language():
    command = [sys.executable, "-c", "from viewimit.app.panels.left import PLAY; print(PLAY[0])"]
    ran = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"LANGUAGE": "tlh"}, check=True)
    assert ran.stdout.strip() == "Play"
