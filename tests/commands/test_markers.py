"""The sheet of markers, printed by a browser, has the size that it says, and OpenCV finds each marker on it."""

import numpy as np
import pytest

from viewimit.sensing.detection import Fiducials

cv2 = pytest.importorskip("cv2")
pdfium = pytest.importorskip("pypdfium2")
PX_A_MM = 6.0


def pages(path):
    for page in pdfium.PdfDocument(path):
        yield page, np.asarray(page.render(scale=PX_A_MM * 25.4 / 72).to_pil().convert("RGB"))


@pytest.mark.parametrize(
    "words, size_mm, dictionary, learner, demonstrator",
    [
        ((), 40, "4X4_50", range(20), range(25, 45)),
        (("--size-mm", 25, "--count", 12, "--demonstrator-from", 100, "--aruco", "APRILTAG_36h11"), 25,
         "APRILTAG_36h11", range(12), range(100, 112)),
    ],
)  # fmt: skip
def test_every_marker_is_found_once_on_the_pages_of_its_arm(
    words, size_mm, dictionary, learner, demonstrator, ask, tmp_path, browser
):
    out, fiducials, found = tmp_path / "markers.html", Fiducials(dictionary), {"learner": [], "demonstrator": []}
    status, _, err = ask("markers", "--out", out, *words)
    assert status == 0 and "print it from a browser on A4, at 100 %" in err
    detector = cv2.aruco.ArucoDetector(fiducials.dictionary)
    sheet = browser.new_page()
    sheet.goto(out.as_uri())
    sheet.pdf(path=tmp_path / "markers.pdf", prefer_css_page_size=True, print_background=True)
    sheet.close()
    for page, picture in pages(tmp_path / "markers.pdf"):
        said = page.get_textpage().get_text_range()
        (arm,) = (arm for arm in found if f"Markers of the {arm}" in said)
        found[arm] += fiducials.detect(picture)
        corners, _, _ = detector.detectMarkers(picture)
        sides = np.linalg.norm(np.diff(np.array(corners)[:, 0], axis=1), axis=2) / PX_A_MM
        np.testing.assert_allclose(sides, size_mm, atol=2 / PX_A_MM)
        assert all(f"{number} " in said for number in fiducials.detect(picture))
    assert sorted(found["learner"]) == list(learner) and sorted(found["demonstrator"]) == list(demonstrator)
