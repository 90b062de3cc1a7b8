"""A figure as PDF keeps its lines and its text, and looks as its PNG does. PDFium reads what Typst has written."""

import collections
import io
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from viewimit.drawing.curves import draw_curves
from viewimit.drawing.export import figures
from viewimit.drawing.export.citation import cite
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

pytest.importorskip("typst")
pdfium = pytest.importorskip("pypdfium2")
SVG = "{http://www.w3.org/2000/svg}"
ZOOM = 3  # pixels of a test's picture for each px of a drawing
PT = 0.75  # of a px


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


def test_its_lines_are_lines_and_no_part_of_it_is_a_picture(picture):
    """The landscape's shades of E are a mask, which is no object of the page."""
    kinds = collections.Counter(each.type for each in first_page(figures.as_pdf(picture)).get_objects(max_depth=15))
    shapes = sum(picture.count(f"<{tag} ") for tag in ("path", "line", "circle", "rect"))
    assert kinds[pdfium.raw.FPDF_PAGEOBJ_PATH] >= 0.8 * shapes > 5  # shapes without an extent are left out
    assert kinds[pdfium.raw.FPDF_PAGEOBJ_TEXT] > 5 and kinds[pdfium.raw.FPDF_PAGEOBJ_IMAGE] == 0


def test_it_is_as_large_as_the_drawing_and_looks_as_the_png_does(picture):
    page = first_page(figures.as_pdf(picture))
    width, height = map(float, re.search(r'width="([\d.]+)" height="([\d.]+)"', picture).groups())
    assert page.get_size() == pytest.approx((PT * width, PT * height), abs=0.01)
    png = Image.open(io.BytesIO(figures.as_png(picture, ZOOM))).convert("L")
    shown = page.render(scale=ZOOM / PT).to_pil().convert("L").resize(png.size)
    blurred = [np.asarray(each.reduce(ZOOM), float) for each in (png, shown)]  # edges are drawn differently
    assert np.abs(blurred[0] - blurred[1]).mean() < 2.5  # of 255
    assert np.corrcoef(blurred[0].ravel(), blurred[1].ravel())[0, 1] > 0.97


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


def test_without_typst_it_says_what_to_install(ask, tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "can_render", lambda suffix=".png": False)
    status, _, err = ask("landscape", "--step-deg", "30", "--out", tmp_path / "a.pdf")
    assert status == 2 and "a.pdf: .pdf needs typst: pip install 'viewimit[typst]'; .svg does not" in err
