"""Tables, arrays and pictures that say more, or say it otherwise, than most: read, or refused with the reason."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from viewimit.estimation.views import VIEW_NAMES, VIEWS
from viewimit.sensing.tracks import read_files, read_tidy, read_view

HEAD = "frame,point,x,y,confidence"


def table(tmp_path, *lines, name="view.csv"):
    path = tmp_path / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("said", ["sep=;", '"sep=;"', "SEP=;"])
def test_a_first_line_that_names_the_separator_is_no_heading(tmp_path, said):
    plain = read_view(table(tmp_path, HEAD.replace(",", ";"), "0;tip;1,5;2,5;1"))
    found = read_view(table(tmp_path, said, HEAD.replace(",", ";"), "0;tip;1,5;2,5;1"))
    np.testing.assert_array_equal(found.image, plain.image)
    assert found.points == ("tip",) and found.image.tolist() == [[[1.5, 2.5]]]


@pytest.mark.parametrize("missing", ["NA", "NaN", "N/A", "null", ""])
def test_what_tables_write_for_a_missing_number_is_a_point_that_is_not_seen(tmp_path, missing):
    found = read_view(table(tmp_path, HEAD, "0,tip,1,2,1", f"0,elbow,{missing},{missing},1"))
    assert np.isfinite(found.image[0, found.points.index("tip")]).all()
    assert np.isnan(found.image[0, found.points.index("elbow")]).all()


DLC = ("scorer,me,me,me,me,me,me", "bodyparts,tip,tip,tip,elbow,elbow,elbow", "coords,x,y,likelihood,x,y,likelihood")


def test_cells_that_were_cut_at_the_end_of_a_trackers_row_are_empty(tmp_path):
    found = read_view(table(tmp_path, *DLC, "0,1,2,1,3,4,1", "1,5,6,1"))
    assert np.isfinite(found.image[0]).all() and np.isnan(found.image[1, 1]).all()
    with pytest.raises(ValueError, match="8 cells, but 7 columns"):
        read_view(table(tmp_path, *DLC, "0,1,2,1,3,4,1,9"))


@pytest.mark.parametrize("kind", ["external", "virtual", "soft link", "external link"])
def test_data_in_other_files_is_not_read(tmp_path, kind):
    h5py = pytest.importorskip("h5py")
    secret, path = tmp_path / "secret.h5", tmp_path / "tracks.h5"
    with h5py.File(secret, "w") as file:
        file["tracks"] = np.zeros((1, 2, 3, 4))
    with h5py.File(path, "w") as file:
        if kind == "external":
            file.create_dataset("tracks", (1, 2, 3, 4), "f8", external=[(str(secret), 0, 192)])
        elif kind == "virtual":
            layout = h5py.VirtualLayout((1, 2, 3, 4), "f8")
            layout[...] = h5py.VirtualSource(str(secret), "tracks", (1, 2, 3, 4))
            file.create_virtual_dataset("tracks", layout)
        elif kind == "soft link":
            file["real"] = np.zeros((1, 2, 3, 4))
            file["tracks"] = h5py.SoftLink("/real")
        else:
            file["tracks"] = h5py.ExternalLink(str(secret), "/tracks")
    with pytest.raises(ValueError, match="is a link, which is not followed|has its data in other files"):
        read_view(path)


HEADING = "frame,view,point,x,y"


@pytest.mark.parametrize("widest, says", [(99, "percent"), (250, "TAPIR"), (620, None), (-30, "percent")])
def test_coordinates_that_may_be_no_pixels_are_named(tmp_path, widest, says):
    rows = [
        f"0,{VIEW_NAMES[view]},{k},{abs(widest) * (k + 1) / 6},{widest * (6 - k) / 6}"
        for view in VIEWS
        for k in range(6)
    ]
    tracked = read_tidy(table(tmp_path, HEADING, *rows))
    doubt = tracked.doubtful_units()
    assert doubt is None if says is None else says in doubt
    assert tracked.doubtful_place() is None
    lost = [f"{cells.rsplit(',', 2)[0]},639,479" if int(cells.split(",")[2]) > 2 else cells for cells in rows]
    assert "12 points of several names are at (639, 479)" in read_tidy(table(tmp_path, HEADING, *lost)).doubtful_place()


@pytest.mark.parametrize(
    "spans, says",
    [
        ({"L": (1, 8), "R": (1, 8)}, "frames are 0 to 7 in demo_left, demo_right, but 1 to 8 in own_left, own_right"),
        ({"r": (1, 8)}, "0 to 7 in demo_left, own_left, own_right, but 1 to 8 in demo_right"),
        ({}, None),
        ({"L": (1, 7), "R": (1, 7)}, None),  # whose first frame shows nothing
        ({"L": (1, 9), "R": (1, 9)}, None),
        ({"r": (0, 4), "L": (1, 8), "R": (1, 8)}, None),  # of other lengths: it is not said of all
        ({"L": (5, 5), "R": (5, 5)}, None),  # a learner that stands still
    ],
)
def test_frames_that_are_counted_from_0_in_one_table_and_from_1_in_another_are_named(tmp_path, spans, says):
    paths = {}
    for view in VIEWS:
        first, last = spans.get(view, (0, 7))
        rows = [f"{at},{k},{100 + 9 * k + at},{300 - 7 * k}" for at in range(first, last + 1) for k in range(6)]
        paths[view] = tmp_path / f"{VIEW_NAMES[view]}.csv"
        paths[view].write_text("\n".join(["frame,point,x,y", *rows]) + "\n")
    doubt = read_files(paths).doubtful_frames()
    assert doubt is None if says is None else says in doubt and "count them alike" in doubt


def test_the_pages_of_a_tiff_are_frames(tmp_path):
    pytest.importorskip("cv2")
    from viewimit.sensing.detection import read_pictures

    pages = [np.full((40, 60, 3), 10 * k, np.uint8) for k in range(1, 4)]
    first, *others = map(Image.fromarray, pages)
    for name, kept in (("three.tif", others), ("one.tiff", [])):
        first.save(tmp_path / name, save_all=True, append_images=kept)
        found = list(read_pictures(tmp_path / name))
        assert [int(picture[0, 0, 0]) for picture in found] == [10 * k for k in range(1, 2 + len(kept))]


def test_a_closed_standard_output_is_no_error():
    code = "import os, sys; os.close(1); os.execv(sys.executable, [sys.executable, '-m', 'viewimit', 'exam', '--help'])"
    done = subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True)
    assert "Traceback" not in done.stderr
