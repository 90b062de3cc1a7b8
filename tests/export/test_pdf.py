"""A figure as PDF keeps its lines and its text, and looks as its PNG does. PDFium reads what Typst has written."""

import collections
import re
import xml.etree.ElementTree as ET

import pytest

from viewimit.drawing.curves import draw_curves
from viewimit.drawing.export import figures
from viewimit.drawing.export.citation import cite
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

pytest.importorskip("typst")
pdfium = pytest.importorskip("pypdfium2")
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def landscape(tmp_path_factory):
    from viewimit.commands.cli import main

    path = tmp_path_factory.mktemp("landscape") / "a.svg"
    assert main(["landscape", "--step-deg", "5", "--out", str(path)]) == 0
    return path.read_text("utf-8")


@pytest.fixture(scope="module")
def curves():
    session = Session(Settings())
    session.run(4)
    panel = draw_curves(session.history, 4, None, session.scene.moving_joints)
    return figures.stack([panel], "E falls & the joints arrive").captioned(cite(session))


@pytest.fixture(params=["landscape", "curves"])
def picture(request):
    return request.getfixturevalue(request.param)


def first_page(pdf):
    return pdfium.PdfDocument(pdf)[0]


def test_its_text_is_that_of_the_drawing_and_can_be_searched(picture):
    said = first_page(figures.as_pdf(picture)).get_textpage().get_text_range()
    drawn = "".join("".join(node.itertext()) for node in ET.fromstring(picture).iter(f"{SVG}text"))
    letters = [collections.Counter(re.sub(r"[\s\ufffe\xad-]", "", text)) for text in (said, drawn)]
    assert letters[0] == letters[1] and sum(letters[1].values()) > 100


def test_the_same_picture_gives_the_same_file_with_its_title(picture):
    pdf = figures.as_pdf(picture)
    assert pdf == figures.as_pdf(picture)
    title = ET.fromstring(picture).find(f"{SVG}title").text
    assert pdfium.PdfDocument(pdf).get_metadata_value("Title") == title


def test_landscape_evaluate_and_reproduce_write_it(ask, tmp_path):
    assert ask("landscape", "--step-deg", "30", "--out", tmp_path / "landscape.pdf")[0] == 0
    views = Session(Settings(frames=1)).snapshot.views
    rows = (
        f"0,{view},{k},{x},{y}"
        for view in ("demo_left", "demo_right", "own_left", "own_right")
        for k, (x, y) in enumerate(getattr(views, view))
    )
    (tmp_path / "points.csv").write_text("\n".join(["frame,view,point,x,y", *rows]))
    assert ask("evaluate", tmp_path / "points.csv", "--out", tmp_path / "report.pdf")[0] == 0
    assert ask("reproduce", "fig10", "--out", tmp_path)[0] == 0
    for name in ("landscape", "report", "fig10"):
        assert len(first_page(tmp_path / f"{name}.pdf").get_textpage().get_text_range()) > 100
