"""What columns say is read alike in every format, or the reader of the table is told."""

import numpy as np
import pytest
from trackers import Seen, analysis

from viewimit.estimation.views import VIEW_NAMES, VIEWS
from viewimit.sensing.tracks import read_files, read_tidy, read_view

IMAGE = np.random.default_rng(5).uniform(20, 600, (4, 3, 6, 2)).round(2)  # views, frames, points, px
HIDDEN = np.random.default_rng(6).random((4, 3, 6)) < 0.25
NAMES = [f"p{k}" for k in range(6)]


def rows_of(view, frame=str, point=NAMES.__getitem__):
    return [([frame(t), point(k), *map(str, IMAGE[view, t, k])], bool(HIDDEN[view, t, k])) for t, k in np.ndindex(3, 6)]


def plain(folder, heading="frame,point,x,y", more=lambda hidden: "", separator=",", first=(), **of):
    """Files of one view each. more: further cells of a row."""
    paths = {}
    for k, view in enumerate(VIEWS):
        lines = [separator.join([*cells, *filter(None, [more(hidden)])]) for cells, hidden in rows_of(k, **of)]
        paths[view] = folder / f"{VIEW_NAMES[view]}.csv"
        paths[view].write_text("\n".join([*first, heading, *lines]) + "\n")
    return read_files(paths)


def tidy(folder, heading="frame,point,x,y", more=lambda hidden: "", **of):
    lines = [
        ",".join([VIEW_NAMES[view], *cells, *filter(None, [more(hidden)])])
        for k, view in enumerate(VIEWS)
        for cells, hidden in rows_of(k, **of)
    ]
    (folder / "tidy.csv").write_text("\n".join([f"view,{heading}", *lines]) + "\n")
    return read_tidy(folder / "tidy.csv")


def deeplabcut(folder, coords=("x", "y"), more=lambda hidden: (), index=str, after=(), tail=None):
    """tail: the heading of a last column that is no body part's, and its cell."""
    paths, last = {}, ("", f",{tail[0]}", "") if tail else ("", "", "")
    for v, view in enumerate(VIEWS):
        heads = [["scorer", *["net"] * 6 * len(coords)], ["bodyparts", *np.repeat(NAMES, len(coords))]]
        lines = [",".join(head) + end for head, end in zip([*heads, ["coords", *coords * 6]], last)]
        lines = [line if "," in end or not tail else f"{line}," for line, end in zip(lines, last)] + list(after)
        for t in range(3):
            cells = [str(cell) for k in range(6) for cell in (*IMAGE[v, t, k], *more(bool(HIDDEN[v, t, k])))]
            lines.append(",".join([index(t), *cells]) + (f",{tail[1]}" if tail else ""))
        paths[view] = folder / f"{VIEW_NAMES[view]}.csv"
        paths[view].write_text("\n".join(lines) + "\n")
    return read_files(paths)


def arrays(folder, **more):
    paths = {}
    for v, view in enumerate(VIEWS):
        paths[view] = folder / f"{VIEW_NAMES[view]}.npz"
        seen = {name: of(HIDDEN[v]) for name, of in more.items()}
        np.savez(paths[view], pred_tracks=IMAGE[v], names=np.array(NAMES, "SU"[v % 2]), **seen)
    return read_files(paths)


def check(tracked, hidden=True):
    """All points are where they were written, and those that are hidden are not seen."""
    found = tracked.views(0.6)
    seen = np.moveaxis(~HIDDEN, 0, -1) if hidden else np.ones((3, 6, 4), bool)
    np.testing.assert_array_equal(found.visible, seen)
    for k, view in enumerate(VIEWS):
        np.testing.assert_array_equal(tracked.image[view], IMAGE[k])
    assert tracked.points == tuple(NAMES)


FLAGS = [
    ("occluded", "1", "0"), ("Is_Occluded", "True", "False"), ("hidden", "yes", "no"), ("not visible", "t", "f"),
    ("out of frame", "1.0", "0"), ("keypoint_missing", "Y", "N"), ("outlier", "1", ""), ("outside", "1", "0"),
    ("visible", "False", "True"), ("isTracked", "0", "1"), ("visibility", "occluded", "visible"),
    ("in_view", "out", "in"), ("unoccluded", "f", "t"), ("visibility", "1", "2"), ("detected", "0", "1"),
    ("confidence", "0.1", "0.97"), ("Score", "false", "true"), ("pred_likelihood", "0", "1.02"), ("visible", "0", "2"),
]  # fmt: skip


def test_whether_a_point_is_seen_is_read_alike_in_every_format(tmp_path):
    for name, if_hidden, if_seen in FLAGS:
        cell = lambda hidden, words=(if_seen, if_hidden): words[bool(hidden)]
        if if_seen:  # an empty last cell needs its separator
            check(plain(tmp_path, f"frame,point,x,y,{name}", cell))
            check(tidy(tmp_path, f"frame,point,x,y,{name}", cell))
        check(deeplabcut(tmp_path, ("x", "y", name), lambda hidden, cell=cell: (cell(hidden),)))
        if if_seen:
            of = np.vectorize(cell)
            check(arrays(tmp_path, **{name: of}))
            if if_hidden[0].isdigit():
                check(arrays(tmp_path, **{name: lambda hidden, of=of: of(hidden).astype(float)}))


@pytest.mark.parametrize("kind", ["table", "fixed"])
def test_tables_in_hdf5_say_the_same(tmp_path, kind):
    pandas, _, h5py = pytest.importorskip("pandas"), pytest.importorskip("tables"), pytest.importorskip("h5py")
    tracks = {}
    for v, view in enumerate(VIEWS):
        columns = {}
        for k, name in enumerate(NAMES):
            columns |= {("net", name, axis): IMAGE[v, :, k, a] for a, axis in enumerate("xy")}
            columns["net", name, "visible"] = ~HIDDEN[v, :, k]
        frame = pandas.DataFrame(columns)
        frame["net", "set", ""] = ["train", "test", "train"]
        frame.columns.names = ["scorer", "bodyparts", "coords"]
        tracks[view] = tmp_path / f"{v}.h5"
        frame.to_hdf(tracks[view], key="k", format=kind)
    tracked = read_files(tracks)
    check(tracked)
    assert "set" in tracked.notes[0]
    for v, view in enumerate(VIEWS):
        analysis(tracks[view], Seen(IMAGE[[v]], np.ones((1, 3, 6)), np.arange(3), tuple(NAMES), ("",)), names=())
        with h5py.File(tracks[view], "r+") as file:
            file["occluded"], file["notes"] = HIDDEN[v].T[None], [1]
    tracked = read_files(tracks)
    check(tracked)
    assert tracked.notes == ("not read: array notes",)


@pytest.mark.parametrize(
    "name, cell", [("conf. [%]", "97"), ("visibility", "3"), ("occluded", "2"), ("visible", "maybe")]
)
def test_other_values_are_refused_with_their_place(tmp_path, name, cell):
    for read in (plain, tidy):
        with pytest.raises(
            ValueError, match=f"(frame 0, point p0|line 2, column).*{name if cell == 'maybe' else cell}"
        ):
            read(tmp_path, f"frame,point,x,y,{name}", lambda hidden: cell)
    with pytest.raises(ValueError, match="npz: .*(frame 0, point p0|yes or no)"):
        arrays(tmp_path, **{name: np.vectorize(lambda hidden: cell)})


@pytest.mark.parametrize("name", ["z", "Z (mm)", "depth", "w", "box_height", "x2"])
def test_columns_that_change_what_x_and_y_are_refuse_the_table_in_every_format(tmp_path, name):
    for read in (
        lambda: plain(tmp_path, f"frame,point,x,y,{name}", lambda hidden: "7"),
        lambda: tidy(tmp_path, f"frame,point,x,y,{name}", lambda hidden: "7"),
        lambda: deeplabcut(tmp_path, ("x", "y", name), lambda hidden: ("7",)),
        lambda: arrays(tmp_path, **{name: lambda hidden: np.ones(hidden.shape)}),
    ):
        with pytest.raises(ValueError, match=f"column {name}".replace("(", r"\(").replace(")", r"\)")):
            read()


@pytest.mark.parametrize(
    "heading", ["frame,point,x (mm),y (mm)", "frame,point,x_norm,y_norm", "frame,point,x (%),y (%)"]
)
def test_headings_with_another_unit_are_refused(tmp_path, heading):
    with pytest.raises(ValueError, match="no pixels"):
        plain(tmp_path, heading)


@pytest.mark.parametrize(
    "frame, numbers",
    [
        (lambda t: f"{1423155837204827070 + 33333333 * t}", [1423155837204827070 + 33333333 * t for t in range(3)]),
        (lambda t: f"{2**64 - 4 + t}", [2**64 - 4 + t for t in range(3)]),
        (lambda t: f"{t:.18e}", [0, 1, 2]),
        (lambda t: f"frame_{t:06}.png", [0, 1, 2]),
        (lambda t: f"labeled-data/take7/frame{t:04}_cam1.png", [0, 1, 2]),
        (lambda t: f"cam2_frame_{4 + t:04}.png", [4, 5, 6]),
        (lambda t: f"C:\\take\\2026-11-28_img{t}_t{100 + 33 * t}ms.jpeg", [0, 1, 2]),
        (lambda t: f'"{t + 1}"', [1, 2, 3]),
    ],
)
def test_frames_are_whole_numbers_and_pictures_in_every_format(tmp_path, frame, numbers):
    for tracked in (
        plain(tmp_path, frame=frame), tidy(tmp_path, "image,point,x,y", frame=frame), deeplabcut(tmp_path, index=frame),
        plain(tmp_path, "timestamp,point,x,y", frame=frame),
    ):  # fmt: skip
        check(tracked, hidden=False)
        assert tracked.frames == tuple(numbers)
    stored = arrays(tmp_path, frames=lambda hidden: np.array([frame(t).strip('"') for t in range(3)]))
    assert stored.frames == tuple(numbers) and not stored.notes


@pytest.mark.parametrize(
    "frame", [lambda t: f"{t / 30:.3f}", lambda t: "first", lambda t: f"-{t + 1}", lambda t: "2e99"]
)
def test_what_numbers_no_frame_is_refused(tmp_path, frame):
    for read in (lambda: plain(tmp_path, frame=frame), lambda: tidy(tmp_path, frame=frame)):
        with pytest.raises(ValueError, match=r"csv: line \d+, column frame: .* whole number"):
            read()


@pytest.mark.parametrize(
    "first, heading",
    [
        (["# tracked by script v2"], "frame,point,x,y"), (["# a, b", "%", "", "// c"], "frame,point,x,y"),
        ([], "# frame,point,x,y"), (["# by me"], "#frame,point,x,y"), (["\ufeff# by me"], "frame,point,x,y"),
    ],
)  # fmt: skip
def test_comments_are_skipped_and_a_heading_may_be_one(tmp_path, first, heading):
    check(plain(tmp_path, heading, first=first), hidden=False)


@pytest.mark.parametrize(
    "low, high, refused",
    [
        (-0.05, 1.04, True), (-1.0, 1.0, True), (-1.1, 0.9, True), (500.0, 501.2, True), ((0, 0), (1, 480), True),
        (-250.0, 250.0, False), (100.0, 140.0, False), ((320, 0), (323, 480), False),
    ],
)  # fmt: skip
def test_pixels_are_judged_by_the_extent_of_the_body(tmp_path, low, high, refused):
    paths = {}
    for k, view in enumerate(VIEWS):
        image = np.array(low) + np.subtract(high, low) * (IMAGE[k] - 20) / 580
        image[1, 2] = 900  # one stray
        paths[view] = tmp_path / f"{k}.npz"
        np.savez(paths[view], pred_tracks=image, names=NAMES)
    if refused:
        with pytest.raises(ValueError, match="no pixels"):
            read_files(paths)
    else:
        assert read_files(paths).points == tuple(NAMES)


def in_views(folder, names):
    """Points under other names in each view."""
    paths = {}
    for k, view in enumerate(VIEWS):
        paths[view] = folder / f"{k}.csv"
        rows = [f"{name},{x},{y}" for name, (x, y) in zip(names[k], IMAGE[k, 0])]
        paths[view].write_text("\n".join(["point,x,y", *rows]) + "\n")
    return read_files(paths)


def test_spellings_of_one_name_are_one_point_unless_a_view_has_both(tmp_path):
    usual = ["left wrist", "elbow1", "tip", "3", "p1_2", "base"]
    other = ["Left.Wrist\u200b ", "elbow_1", "TIP", "3.0", "p1-2", " base"]
    tracked = in_views(tmp_path, [usual, usual, usual, other])
    assert tracked.points == tuple(usual) and tracked.views().usable.all()
    assert not tracked.unmatched_names() and "elbow_1 = elbow1" in tracked.notes[0]
    both = ["a", "A", "p12", "p1_2", "c", "d"]
    tracked = in_views(tmp_path, [both, both, ["a", "b", *both[2:]], both])
    assert tracked.points == (*both, "b")


def test_of_several_columns_the_one_that_says_least_counts(tmp_path):
    check(plain(tmp_path, "frame,point,x,y,score,occluded", lambda hidden: f"0.9,{int(hidden)}"))
    check(tidy(tmp_path, "frame,point,x,y,v,c", lambda hidden: f"{2 - hidden},0.9"))


def test_of_several_columns_for_the_frame_the_number_counts(tmp_path):
    more = lambda hidden: "take.png,1733000000.5,arm,0.4"
    tracked = plain(tmp_path, "image_id,point,x,y,file_name,timestamp,joint,instance_score", more)
    check(tracked, hidden=False)
    assert tracked.notes == ("not read: columns file_name, timestamp, joint, instance_score",)


def test_the_level_of_the_scorer_may_be_missing(tmp_path):
    deeplabcut(tmp_path)
    paths = {view: tmp_path / f"{VIEW_NAMES[view]}.csv" for view in VIEWS}
    for path in paths.values():
        path.write_text(path.read_text().partition("\n")[2])
    check(read_files(paths), hidden=False)


def test_comments_among_the_rows_are_counted_and_names_may_begin_with_a_sign(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("frame,point,x,y\n0,a,1,2\n#0,b,3,4\n% done\n0,c,5,6\n")
    track = read_view(path)
    assert track.points == ("a", "c") and "2 lines" in track.unread
    path.write_text("point,x,y\n#1,1,2\n#2,3,4\n")
    assert read_view(path).points == ("#1", "#2")


def test_a_picture_is_no_name_of_a_point(tmp_path):
    path = tmp_path / "Results.csv"
    path.write_text(" ,Label,X,Y,Slice\n1,IMG_0001.jpg,239.3,221.8,1\n2,IMG_0001.jpg,260.5,217.7,1\n")
    with pytest.raises(ValueError, match="column Label: .*picture"):
        read_view(path)
    path.write_text(path.read_text().replace(".jpg", ""))
    with pytest.raises(ValueError, match="column Label names one point"):
        read_view(path)
