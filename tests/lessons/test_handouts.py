"""Handouts: every step on A4 pages, in HTML and PDF, with room to answer or with the solutions."""

import re
import sys

import pytest
from drawn import parsed
from msgspec.structs import replace
from viewimit.app.lab.lessons import sheet, source
from viewimit.app.lab.lessons.format import Choice, Number
from viewimit.app.lab.lessons.handout import BLANK, handout

from viewimit.commands.cli import main

LESSONS = source.shipped()
SVG = "{http://www.w3.org/2000/svg}"


def pages_of(text: str) -> list:
    body = re.search(r"<body>(.*)</body>", text, re.S)[1]
    return parsed(f"<div>{body}</div>").findall(f".//{SVG}svg") or parsed(f"<div>{body}</div>").findall(".//svg")


def words_of(text: str) -> str:
    texts = [element for page in pages_of(text) for element in page.iter() if element.tag.endswith("text")]
    return " ".join(element.text or "" for element in texts)


@pytest.mark.parametrize("solutions", [False, True])
@pytest.mark.parametrize("name", LESSONS)
def test_every_step_stands_on_a_page_and_nothing_beyond_its_edge(name, solutions):
    lesson = LESSONS[name]
    text = handout(lesson, "html", solutions)
    words = re.sub(r"\s+", " ", words_of(text))
    for step in lesson.step:
        assert step.title in words
        ask = step.ask
        if isinstance(ask, Choice):
            assert all(" ".join(answer.text.split()[:2]) in words for answer in ask.answers)
    assert ("Now say it in one sentence:" in words) == (not solutions)
    assert ("Now you can say" in words) == solutions
    for page in pages_of(text):
        for element in page.iter():
            numbers = re.findall(r"-?\d+\.\d+", element.get("d", "")) if element.tag.endswith("path") else []
            xs, ys = map(float, numbers[::2]), map(float, numbers[1::2])
            assert all(0 <= x <= sheet.WIDTH for x in xs) and all(0 <= y <= sheet.HEIGHT for y in ys)
            if element.tag.endswith("text"):
                size, left = float(element.get("font-size")) / sheet.PT, float(element.get("x"))
                right = left + sheet.text_width(element.text or "", size, element.get("font-weight") == "600")
                assert 0 <= left and right <= sheet.WIDTH - 3
                assert 0 < float(element.get("y")) < sheet.HEIGHT - 5


def test_a_handout_does_not_give_the_answers_away():
    lesson = LESSONS["tour"]
    asked, solved = (words_of(handout(lesson, "html", solutions)) for solutions in (False, True))
    for step in lesson.step:
        said = " ".join(re.sub(r"[*{}]", "", step.say).split()[:4])
        assert said not in re.sub(r"\s+", " ", asked)
    assert "right." in solved and "right." not in asked


def test_a_click_is_a_cross_on_paper():
    words = re.sub(r"\s+", " ", words_of(handout(LESSONS["tour"], "html")))
    assert "Mark in L with a cross where the two lines cross." in words
    assert "Mark on the empty map with a cross where E is smallest." in words and "Click" not in words


@pytest.mark.parametrize("high", [1.0, 3.0, 40.0, 360.0, 100_000.0])
def test_a_scale_of_any_length_has_a_few_round_numbers(high):
    lesson = LESSONS["tour"]
    ask = Number(question="How many?", unit="", low=0.0, high=high, truth="E", close="", far="")
    asking = replace(lesson, step=(replace(lesson.step[0], ask=ask),))
    texts = [element.text for page in pages_of(handout(asking, "html")) for element in page.iter()]
    ticks = [float(text) for text in texts if text and re.fullmatch(r"\d[\d.]*(e\+\d+)?", text)]
    assert 0.0 in ticks and 4 <= len(ticks) <= 10, texts
    assert max(ticks) <= high and max(ticks) >= 0.8 * high


def test_numbers_of_the_library_stand_in_the_solutions():
    words = re.sub(r"\s+", " ", words_of(handout(LESSONS["motion"], "html", True)))
    assert re.search(r"The circle is \d+ mm wide", words) and re.search(r"Between the two hands: \d+ mm", words)
    for lesson in LESSONS.values():  # what depends on a student is left out
        assert BLANK not in words_of(handout(lesson, "html", True))


def test_a_pdf_has_the_same_pages_and_its_fonts():
    pytest.importorskip("fpdf")
    for solutions in (False, True):
        data = handout(LESSONS["tour"], "pdf", solutions)
        assert data.startswith(b"%PDF-") and len(data) < 300_000
        assert len(re.findall(rb"/Type /Page\b", data)) == len(pages_of(handout(LESSONS["tour"], "html", solutions)))
        assert data.count(b"/FontFile2") == 2 and b"Inter" in data


def test_text_is_broken_into_lines_that_fit():
    text = "One **bold term** among other words that need several lines of a narrow column."
    lines = sheet.wrapped(text, 10, 40)
    assert len(lines) > 2
    for line in lines:
        width = sum(sheet.text_width(word, 10, bold) for word, bold in line[:-1])
        assert width + sheet.text_width(line[-1][0].rstrip(), 10, line[-1][1]) <= 40
    words = [(word.strip(), bold) for line in lines for word, bold in line]
    assert ("bold", True) in words and ("other", False) in words
    assert " ".join(word for word, _ in words if word) == text.replace("**", "")


@pytest.mark.parametrize("name", ["a.html", "a.pdf"])
def test_a_command_writes_it(name, tmp_path, capsys):
    if name.endswith("pdf"):
        pytest.importorskip("fpdf")
    assert main(["handout", "--lesson", "ray", "--out", str(tmp_path / name)]) == 0
    assert (tmp_path / name).stat().st_size > 10_000 and "A4" in capsys.readouterr().err


def test_the_command_says_what_pdf_needs(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "fpdf", None)
    assert main(["handout", "--lesson", "ray", "--out", str(tmp_path / "a.pdf")]) == 2
    assert "pip install 'viewimit[pdf]'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"), [(["--out", "a.doc"], ".html or .pdf"), (["--lesson", "x"], "there are ray")]
)
def test_the_command_names_what_is_wrong(options, said, capsys):
    assert main(["handout", *options]) == 2
    assert said in capsys.readouterr().err
