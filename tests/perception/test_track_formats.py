"""Files as other packages write them: DeepLabCut's tables by pandas, SLEAP's by its layouts, arrays by numpy."""

import json
import pickle
import struct
from itertools import product

import numpy as np
import pytest

from viewimit.perception.tracks import read_files, read_tidy, read_view
from viewimit.views import VIEWS

PARTS, FRAMES = ("tip", "elbow", "base"), np.array([0, 1, 4])
RNG = np.random.default_rng(0)
IMAGE = RNG.uniform(0, 600, (2, 3, 3, 2)).round(3)  # individuals, frames, parts, px
SURE = RNG.uniform(0.5, 1, (2, 3, 3)).round(3)
IMAGE[:, 1, 2] = np.nan  # the base is not seen in the second frame
WHO = ("m1", "m2")


def same(track, who=0, likelihood=True, parts=PARTS, frames=FRAMES):
    order = [track.points.index(part) for part in parts]
    assert sorted(track.points) == sorted(parts)
    np.testing.assert_array_equal(track.frames, frames)
    np.testing.assert_allclose(track.image[:, order], IMAGE[who], atol=1e-9)
    seen = np.isfinite(IMAGE[who]).all(-1)
    sure = track.confidence[:, order][seen]
    np.testing.assert_allclose(sure, SURE[who][seen] if likelihood else 1.0, atol=1e-6)


# DeepLabCut: as deeplabcut/pose_estimation_*/…, create_project and generate_training_dataset make their frames


KINDS, INDICES = ("csv", "table", "fixed"), ("number", "path", "backslash", "levels")  # pandas writes no such table


def frame_of_pandas(several, likelihood, index):
    pandas = pytest.importorskip("pandas")
    coords = ["x", "y", "likelihood"] if likelihood else ["x", "y"]
    levels = [["net"], *([list(WHO)] if several else []), list(PARTS), coords]
    names = ["scorer", *(["individuals"] if several else []), "bodyparts", "coords"]
    values = np.concatenate([IMAGE, SURE[..., None]], -1)[..., : len(coords)]
    values = (values if several else values[:1]).transpose(1, 0, 2, 3).reshape(3, -1)
    columns = pandas.MultiIndex.from_product(levels, names=names)
    paths = [("labeled-data", "reach2", f"img{k:04}.png") for k in FRAMES]
    rows = {
        "number": FRAMES,
        "path": ["/".join(path) for path in paths],
        "backslash": ["\\".join(path) for path in paths],
        "levels": pandas.MultiIndex.from_tuples(paths),
    }
    return pandas.DataFrame(values, columns=columns, index=rows[index])


@pytest.mark.parametrize("likelihood", [True, False], ids=["predicted", "CollectedData"])
@pytest.mark.parametrize("several", [False, True], ids=["single", "multi-animal"])
@pytest.mark.parametrize("kind, index", [pair for pair in product(KINDS, INDICES) if pair != ("table", "levels")])
def test_deeplabcuts_tables_as_pandas_writes_them(tmp_path, kind, several, likelihood, index):
    frame = frame_of_pandas(several, likelihood, index)
    path = tmp_path / f"tracks.{'csv' if kind == 'csv' else 'h5'}"
    if kind == "csv":
        frame.to_csv(path)
    else:
        pytest.importorskip("tables"), pytest.importorskip("h5py")
        frame.to_hdf(path, key="df_with_missing", format=kind, mode="w")
    if not several:
        return same(read_view(path), likelihood=likelihood)
    for who, name in enumerate(WHO):
        same(read_view(path, name), who, likelihood)
    with pytest.raises(ValueError, match="it has m1, m2: say who is whom by --demonstrator NAME and --learner NAME"):
        read_view(path)
    with pytest.raises(ValueError, match="nobody is named 'm3'; it has m1, m2"):
        read_view(path, "m3")


def test_headings_that_would_run_something_are_not_unpickled(tmp_path):
    h5py = pytest.importorskip("h5py")
    path, harm = tmp_path / "evil.h5", tmp_path / "harm"
    frame_of_pandas(False, True, "number").to_hdf(path, key="df_with_missing", format="table", mode="w")

    class Harm:
        def __reduce__(self):
            return open, (str(harm), "w")

    with h5py.File(path, "r+") as file:
        file["df_with_missing/table"].attrs["values_block_0_kind"] = np.bytes_(pickle.dumps(Harm(), 0))
    with pytest.raises(ValueError, match="evil.h5: its headings cannot be read: it asks for"):
        read_view(path)
    assert not harm.exists()


@pytest.mark.parametrize(
    "change, says",
    [
        (("bodyparts", "parts"), "its first lines must begin with scorer, bodyparts, coords or scorer, individuals"),
        (("tip,tip,tip", "tip,tip,top"), None),
        (("coords,x", "coords,z"), "body part 'tip' needs columns x and y"),
        (("\n1,", "\nframe one,"), "line 5, column 1: 'frame one' is neither a whole number from 0 nor a picture"),
        (("\n1,", "\n0,"), "frame 0 stands in two rows"),
    ],
)
def test_faults_of_deeplabcuts_tables_are_named(tmp_path, change, says):
    path = tmp_path / "tracks.csv"
    frame_of_pandas(False, True, "number").to_csv(path)
    path.write_text(path.read_text().replace(*change))
    if says is None:
        says = "body part 'top' needs columns x and y"
    with pytest.raises(ValueError, match=says) as found:
        read_view(path)
    assert str(path) in str(found.value)


# SLEAP: as sleap/info/write_tracking_h5.py, sleap/io/format/hdf5.py and sleap-io's csv.py write theirs


def analysis(path, dims=None, names=WHO):
    h5py = pytest.importorskip("h5py")
    tracks = np.full((2, 5, 3, 2), np.nan)
    scores = np.full((2, 5, 3), np.nan)
    tracks[:, FRAMES], scores[:, FRAMES] = IMAGE, SURE
    tracks, scores = tracks[: len(names) or 1], scores[: len(names) or 1]
    stored = dims or ("track", "xy", "node", "frame")
    order = [("track", "frame", "node", "xy").index(name) for name in stored]
    with h5py.File(path, "w") as file:
        file.create_dataset("track_names", data=[np.bytes_(name) for name in names])
        file.create_dataset("node_names", data=[np.bytes_(name) for name in PARTS])
        file.create_dataset("tracks", data=tracks.transpose(order), compression="gzip")
        flat = [("track", "frame", "node").index(name) for name in stored if name != "xy"]
        file.create_dataset("point_scores", data=scores.transpose(flat), compression="gzip")
        file.create_dataset("track_occupancy", data=np.isfinite(tracks).any((2, 3)).T.astype(np.uint8))
        if dims:
            file["tracks"].attrs["dims"] = json.dumps(dims)


@pytest.mark.parametrize("dims", [None, ("frame", "track", "node", "xy"), ("frame", "node", "xy", "track")])
def test_sleaps_analysis_files(tmp_path, dims):
    analysis(tmp_path / "a.h5", dims)
    for who, name in enumerate(WHO):
        same(read_view(tmp_path / "a.h5", name), who)
    with pytest.raises(ValueError, match="it has m1, m2"):
        read_view(tmp_path / "a.h5")
    analysis(tmp_path / "one.h5", dims, names=())
    same(read_view(tmp_path / "one.h5"))


def slp(path, tracked=True, labelled=()):
    """labelled: positions of frames that have an instance by hand too, 5 px beside the predicted one."""
    h5py = pytest.importorskip("h5py")
    point = [("x", "f8"), ("y", "f8"), ("visible", "?"), ("complete", "?")]
    instance = [
        ("instance_id", "i8"), ("instance_type", "u1"), ("frame_id", "u8"), ("skeleton", "u4"), ("track", "i4"),
        ("from_predicted", "i8"), ("score", "f4"), ("point_id_start", "u8"), ("point_id_end", "u8"),
        ("tracking_score", "f4"),
    ]  # fmt: skip
    frames, instances, points, predicted = [], [], [], []
    for t, number in enumerate(FRAMES):
        first = len(instances)
        for who in range(2 if tracked else 1):
            track = who if tracked else -1
            start = len(predicted)
            predicted += [(x, y, np.isfinite(x), False, s) for (x, y), s in zip(IMAGE[who, t], SURE[who, t])]
            instances.append((len(instances), 1, t, 0, track, -1, 0.5, start, len(predicted), np.nan))
            if t in labelled:
                start = len(points)
                points += [(x + 5, y + 5, np.isfinite(x), True) for x, y in IMAGE[who, t]]
                instances.append((len(instances), 0, t, 0, track, -1, np.nan, start, len(points), np.nan))
        frames.append((t, 0, number, first, len(instances)))
    # the skeleton has an order of its own
    nodes = [{"name": name, "weight": 1.0} for name in reversed(PARTS)]
    skeleton = {"directed": True, "graph": {"name": "arm"}, "links": [], "nodes": [{"id": k} for k in (2, 1, 0)]}
    with h5py.File(path, "w") as file:
        file.create_group("metadata").attrs["format_id"] = 1.2
        told = {"version": "2.0.0", "skeletons": [skeleton], "nodes": nodes, "videos": [], "tracks": []}
        file["metadata"].attrs["json"] = np.bytes_(json.dumps(told))
        file["tracks_json"] = [np.bytes_(json.dumps([0, name])) for name in (WHO if tracked else ())]
        if not tracked:
            del file["tracks_json"]
            file.create_dataset("tracks_json", (0,), h5py.string_dtype())
        file["videos_json"] = [np.bytes_(json.dumps({"backend": {"filename": "a.mp4"}}))]
        heads = [("frame_id", "u8"), ("video", "u4"), ("frame_idx", "u8")]
        heads += [("instance_id_start", "u8"), ("instance_id_end", "u8")]
        for name, rows, kind in (
            ("frames", frames, heads), ("instances", instances, instance), ("points", points, point),
            ("pred_points", predicted, [*point, ("score", "f8")]),
        ):  # fmt: skip
            file.create_dataset(name, data=np.array(rows, kind))


def test_sleaps_own_files(tmp_path):
    slp(tmp_path / "two.slp")
    for who, name in enumerate(WHO):
        same(read_view(tmp_path / "two.slp", name), who)
    with pytest.raises(ValueError, match="it has m1, m2"):
        read_view(tmp_path / "two.slp")
    slp(tmp_path / "one.slp", tracked=False)
    same(read_view(tmp_path / "one.slp"))


def test_what_is_labelled_by_hand_goes_before_what_was_predicted(tmp_path):
    slp(tmp_path / "both.slp", labelled=(1,))
    track = read_view(tmp_path / "both.slp", "m2")
    np.testing.assert_allclose(track.image[[0, 2]], IMAGE[1][[0, 2]])
    np.testing.assert_allclose(track.image[1], IMAGE[1, 1] + 5)
    assert (track.confidence[1, :2] == 1.0).all()


def sleap_csv(path, tracks=WHO, empty=False):
    heads = ["track", "frame_idx", "instance.score"]
    heads += [f"{part}.{what}" for part in sorted(PARTS) for what in ("score", "x", "y")]
    lines = [",".join(heads)]
    for t, number in enumerate(FRAMES):
        for who, name in enumerate(tracks):
            cells = [name, str(number), "0.5"]
            for k in np.argsort(PARTS):
                x, y = IMAGE[who, t, k]
                cells += [repr(float(SURE[who, t, k])), *("" if np.isnan(v) else repr(float(v)) for v in (x, y))]
            lines.append(",".join(cells))
        if empty and number == 1:
            lines += [f",{k}," + "," * (len(heads) - 3) for k in (2, 3)]
    path.write_text("\n".join(lines) + "\n")


def test_sleaps_tables(tmp_path):
    sleap_csv(tmp_path / "two.csv")
    for who, name in enumerate(WHO):
        same(read_view(tmp_path / "two.csv", name), who)
    sleap_csv(tmp_path / "one.csv", tracks=("",), empty=True)
    same(read_view(tmp_path / "one.csv"))
    sleap_csv(tmp_path / "untracked.csv", tracks=("", ""))
    with pytest.raises(
        ValueError, match="line 3: point base of frame 0 stands in line 2 too: instances without a track"
    ):
        read_view(tmp_path / "untracked.csv")


@pytest.mark.parametrize("name", ["broken.h5", "broken.slp"])
def test_files_that_are_no_hdf5_or_hold_something_else(tmp_path, name, monkeypatch):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / name
    with pytest.raises(FileNotFoundError):
        read_view(path)
    path.write_text("frame,x,y")
    with pytest.raises(ValueError, match=f"{name}: not an HDF5 file"):
        read_view(path)
    with h5py.File(path, "w") as file:
        file["something"] = [1, 2]
    with pytest.raises(ValueError, match="neither DeepLabCut's table nor SLEAP's tracks are in it; export them as CSV"):
        read_view(path)
    with h5py.File(path, "w") as file:
        file["instances"] = [1, 2]
        file.create_group("metadata").attrs["json"] = '{"skeletons": [{"nodes": []}], "nodes": []}'
    with pytest.raises(ValueError, match="it lacks what files of its kind have: .*tracks_json"):
        read_view(path)
    monkeypatch.setattr("importlib.util.find_spec", lambda package: None)
    with pytest.raises(ValueError, match=r"pip install 'viewimit\[hdf5\]', or export the tracks as CSV"):
        read_view(path)


# Arrays: as CoTracker's and TAPIR's demos hold them

CO = np.nan_to_num(IMAGE[0])  # (frames, points, 2)
SEEN = np.isfinite(IMAGE[0]).all(-1)
NUMBERED = np.arange(3)


def check_arrays(track, names=PARTS):
    assert track.points == tuple(names)
    seen = track.confidence > 0
    np.testing.assert_array_equal(seen, SEEN)
    np.testing.assert_allclose(track.image[seen], IMAGE[0][seen], rtol=1e-6)


def test_arrays_of_cotracker_and_tapir(tmp_path):
    path = tmp_path / "tracks.npz"
    np.savez(path, pred_tracks=CO[None].astype("f4"), pred_visibility=SEEN[None], names=PARTS)
    check_arrays(read_view(path))
    np.savez(path, pred_tracks=CO[None], pred_visibility=SEEN[None, ..., None].astype(float))
    check_arrays(read_view(path), "012")
    np.savez(path, tracks=CO.swapaxes(0, 1), visibles=SEEN.T, names=PARTS)
    check_arrays(read_view(path))
    np.savez(path, tracks=CO.swapaxes(0, 1), occluded=~SEEN.T)
    check_arrays(read_view(path), "012")


def test_names_tell_which_axis_is_of_points_where_nothing_else_does(tmp_path):
    path = tmp_path / "tracks.npy"
    np.save(path, IMAGE[0][:2])
    with pytest.raises(ValueError, match=r"tracks has shape \(2, 3, 2\): which axis is of points\?"):
        read_view(path)
    (tmp_path / "tracks.txt").write_text("tip\nelbow\nbase\n")
    track = read_view(path)
    np.testing.assert_array_equal(track.image, IMAGE[0][:2])
    assert track.points == PARTS
    np.save(path, IMAGE[0][:2].swapaxes(0, 1))
    np.testing.assert_array_equal(read_view(path).image, IMAGE[0][:2])
    (tmp_path / "tracks.txt").write_text("tip\nelbow\nbase\nmore\n")
    with pytest.raises(ValueError, match="4 names, but tracks has shape"):
        read_view(path)


@pytest.mark.parametrize(
    "arrays, says",
    [
        ({"boxes": CO}, "no array pred_tracks or tracks; it has boxes: save as numpy.savez"),
        ({"pred_tracks": CO[..., :1]}, r"pred_tracks has shape \(3, 3, 1\): needs \(frames, points, 2\) px"),
        ({"pred_tracks": CO / 1000}, "all in 0 … 1: multiply x by the picture's width"),
        ({"pred_tracks": CO, "pred_visibility": 9.0 * SEEN - 4}, "not logits"),
        ({"pred_tracks": CO, "pred_visibility": SEEN[:2]}, r"\(2, 3\), which does not fit 3 frames of 3 points"),
        ({"pred_tracks": CO, "names": ("tip", "tip", "base")}, "two points are named 'tip'"),
        ({"pred_tracks": np.where(CO == CO[0, 1, 1], np.inf, CO)}, "frame 0, point 1, y: inf is not a finite number"),
        ({"pred_tracks": np.full((2, 3, 2), np.nan)}, "no point in any frame"),
        ({"tracks": np.array([[object()]])}, "not an array of numbers"),
    ],
)
def test_faults_of_arrays_are_named(tmp_path, arrays, says):
    path = tmp_path / "tracks.npz"
    np.savez(path, **arrays)
    with pytest.raises(ValueError, match=says) as found:
        read_view(path)
    assert str(path) in str(found.value)


# Tables of people and of OpenCV and COLMAP


@pytest.mark.parametrize(
    "heading, rows",
    [
        ("frame,point,x,y,confidence", ["{t},{name},{x},{y},{s}"]),
        ("Frame;Keypoint;X;Y;Score", ["{t};{name};{x:,};{y:,};{s:,}"]),
        ("frame_idx\tname\tpt.x\tpt.y\tlikelihood", ["{t}\t{name}\t{x}\t{y}\t{s}"]),
        ("image_id;point3D_ID;x (px);y (px);confidence", ["{t};{name};{x:,};{y:,};{s:,}", "{t};-1;1,5;2,5;1"]),
        ('"frame","class_id","u","v","size","response","visibility"', ['{t},"{name}",{x},{y},7,0.01,{s}']),
    ],
)
def test_plain_tables_under_other_headings_separators_and_decimals(tmp_path, heading, rows):
    lines = [heading]
    for t, number in enumerate(FRAMES):
        for k, name in enumerate(PARTS):
            for row in rows:
                if SEEN[t, k]:
                    (x, y), s = IMAGE[0, t, k], SURE[0, t, k]
                    point = row.replace("{x:,}", f"{x}".replace(".", ",")).replace("{y:,}", f"{y}".replace(".", ","))
                    point = point.replace("{s:,}", f"{s}".replace(".", ","))
                    lines.append(point.format(t=number, name=name, x=x, y=y, s=s))
    path = tmp_path / "points.csv"
    path.write_text("\n".join(lines) + "\n")
    same(read_view(path))


@pytest.mark.parametrize(
    "text, says",
    [
        ("frame;point;x;y\n0;tip;1.234,5;2", "line 2, column x: '1.234,5': both , and . may be meant"),
        ("frame;point;x;y\n0;tip;1,5;2\n1;tip;1.234;2", "line 3, column x: '1.234': both , and . may be meant"),
        ("frame,point,x,y\n0,tip,1,5,2,5", "line 2: 6 cells, but 4 columns; with decimal commas separate columns by ;"),
        ("frame,x,y\n0,1,2", "line 1: no column point; a table of one view begins with the line frame,point,x,y"),
        ("frame,point,x,u,y\n0,tip,1,1,2", None),
        ("frame,name,id,x,y\n0,tip,1,1,2", "line 1: is point the column name or id"),
        ("point,x,y\ntip,1,2\ntip,3,4", "line 3: point tip of frame 0 stands in line 2 too"),
        ("frame,view,point,x,y\n0,l,tip,1,2", "a table of all four views: give it alone"),
        ("frame,point,x,y\n0,tip,abc,2", "line 2, column x: 'abc' is not a finite number"),
        ("frame,point,x,y\n0,tip,2e6,2", "line 2, column x: '2e6' is no pixel: beyond 1e\\+06"),
        ("", "the file is empty"),
    ],
)
def test_faults_of_plain_tables_are_named_by_line_and_column(tmp_path, text, says):
    path = tmp_path / "points.csv"
    path.write_text(text)
    if says is None:  # x is x, whatever else there is
        assert read_view(path).image.tolist() == [[[1.0, 2.0]]]
        return
    with pytest.raises(ValueError, match=says) as found:
        read_view(path)
    assert str(path) in str(found.value)


def test_a_tidy_table_has_decimal_commas_too(tmp_path):
    lines = [f"0;{view};{name};{k},5;1,25;0,9" for view in VIEWS for k, name in enumerate(PARTS)]
    path = tmp_path / "points.csv"
    path.write_text("\n".join(["frame;view;point;x;y;confidence", *lines]), encoding="utf-8-sig")
    tracked = read_tidy(path)
    assert tracked.points == PARTS and tracked.image["L"][0].tolist() == [[0.5, 1.25], [1.5, 1.25], [2.5, 1.25]]


def test_views_of_different_packages_go_together_by_name(tmp_path, ask, ask_json):
    """Of the demonstrator one frame, labelled by hand; of the learner three."""
    frame_of_pandas(True, True, "number").iloc[:1].to_csv(tmp_path / "l.csv")
    np.savez(tmp_path / "r.npz", pred_tracks=CO[:1], names=PARTS)
    sleap_csv(tmp_path / "own.csv")
    slp(tmp_path / "R.slp")
    paths = {"l": tmp_path / "l.csv", "r": tmp_path / "r.npz", "L": tmp_path / "own.csv", "R": tmp_path / "R.slp"}
    tracked = read_files(paths, {"l": "m1", "L": "m2", "R": "m2"})
    assert tracked.frames == (0, 1, 4) and tracked.points == PARTS
    views = tracked.views()
    np.testing.assert_allclose(views.demo_left, np.broadcast_to(IMAGE[0, :1], (3, 3, 2)))
    np.testing.assert_allclose(views.own_right, IMAGE[1])
    words = [word for view in VIEWS for word in (f"--{view}", paths[view])]
    assert ask("evaluate", *words)[0] == 2
    status, told = ask_json("evaluate", *words, "--demonstrator", "m1", "--learner", "m2")
    assert status == 1 and [frame["frame"] for frame in told["frames"]] == [0, 1, 4]  # three points are too few
    status, _, err = ask("evaluate", paths["R"])
    assert status == 2 and "by --l, --r, --L and --R" in err


@pytest.mark.parametrize(
    "name, says",
    [
        ("t_full.pickle", ".pickle files are not read: DeepLabCut's results are in the .h5 and .csv beside it"),
        ("t.mat", "save it as CSV, frame,point,x,y,confidence"),
        ("t.xlsx", "save the sheet as CSV"),
        ("t.pt", "numpy.savez"),
        ("t.mp4", "viewimit detect"),
        ("t.bin", "colmap model_converter"),
        ("t.c3d", "those are .csv, .tsv, .txt, .h5, .hdf5, .slp, .npz, .npy"),
    ],
)
def test_what_is_not_read_says_how_to_convert_it(tmp_path, ask, name, says):
    (tmp_path / name).write_bytes(struct.pack("d", 1.0))
    words = [word for view in VIEWS for word in (f"--{view}", tmp_path / name)]
    status, out, err = ask("evaluate", *words)
    assert status == 2 and not out and err.count("\n") == 1 and name in err and says in err
