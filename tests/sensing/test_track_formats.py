"""Files as other packages write them: DeepLabCut's tables by pandas, SLEAP's by its layouts, arrays by numpy."""

import pickle
import re
import shlex
import struct
import subprocess
import sys
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from trackers import Seen, analysis, frame_of_pandas, sleap_csv, slp

from viewimit.estimation.views import VIEW_NAMES, VIEWS, view_of
from viewimit.options import option
from viewimit.sensing.tracks import read_files, read_view

ROOT = Path(__file__).parent.parent.parent
PARTS, FRAMES = ("tip", "elbow", "base"), np.array([0, 1, 4])
RNG = np.random.default_rng(0)
IMAGE = RNG.uniform(0, 600, (2, 3, 3, 2)).round(3)  # individuals, frames, parts, px
SURE = RNG.uniform(0.5, 1, (2, 3, 3)).round(3)
IMAGE[:, 1, 2] = np.nan  # the base is not seen in the second frame
WHO = ("m1", "m2")
SEEN_BY = Seen(IMAGE, SURE, FRAMES, PARTS, WHO)


def same(track, who=0, likelihood=True, parts=PARTS, frames=FRAMES):
    order = [track.points.index(part) for part in parts]
    assert sorted(track.points) == sorted(parts)
    np.testing.assert_array_equal(track.frames, frames)
    np.testing.assert_allclose(track.image[:, order], IMAGE[who], atol=1e-9)
    seen = np.isfinite(IMAGE[who]).all(-1)
    sure = track.confidence[:, order][seen]
    np.testing.assert_allclose(sure, SURE[who][seen] if likelihood else 1.0, atol=1e-6)


KINDS, INDICES = ("csv", "table", "fixed"), ("number", "path", "backslash", "levels")  # pandas writes no such table


@pytest.mark.parametrize("several, likelihood", [(False, False), (True, True)], ids=["single", "multi-animal"])
@pytest.mark.parametrize("kind, index", [pair for pair in product(KINDS, INDICES) if pair != ("table", "levels")])
def test_deeplabcuts_tables_as_pandas_writes_them(tmp_path, kind, several, likelihood, index):
    frame = frame_of_pandas(SEEN_BY, several, likelihood, index)
    path = tmp_path / f"tracks.{'csv' if kind == 'csv' else 'h5'}"
    if kind == "csv":
        frame.index.name = "frame (25 fps)"  # pandas writes a row for it
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
    frame_of_pandas(SEEN_BY, False, True, "number").to_hdf(path, key="df_with_missing", format="table", mode="w")

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
        (("bodyparts", "parts"), "its first lines must begin with scorer, individuals, bodyparts, coords"),
        (("tip,tip,tip", "tip,tip,top"), "body part 'top' needs columns x and y"),
        (("coords,x,y", "coords,likelihood,y"), "body part 'tip' needs columns x and y"),
        (("coords,x,y", "coords,x,x"), "two columns are x of 'tip'"),
        (("\n1,", "\nframe one,"), "line 5, column 1: 'frame one' is not a whole number"),
        (("\n1,", "\n0,"), "frame 0 stands in two rows"),
    ],
)
def test_faults_of_deeplabcuts_tables_are_named(tmp_path, change, says):
    path = tmp_path / "tracks.csv"
    frame_of_pandas(SEEN_BY, False, True, "number").to_csv(path)
    path.write_text(path.read_text().replace(*change))
    with pytest.raises(ValueError, match=says) as found:
        read_view(path)
    assert str(path) in str(found.value)


@pytest.mark.parametrize("dims", [None, ("frame", "track", "node", "xy"), ("frame", "node", "xy", "track")])
def test_sleaps_analysis_files(tmp_path, dims):
    analysis(tmp_path / "a.h5", SEEN_BY, dims)
    for who, name in enumerate(WHO):
        same(read_view(tmp_path / "a.h5", name), who)
    with pytest.raises(ValueError, match="it has m1, m2"):
        read_view(tmp_path / "a.h5")
    analysis(tmp_path / "one.h5", SEEN_BY, dims, names=())
    same(read_view(tmp_path / "one.h5"))


def test_sleaps_own_files(tmp_path):
    slp(tmp_path / "two.slp", SEEN_BY)
    for who, name in enumerate(WHO):
        same(read_view(tmp_path / "two.slp", name), who)
    with pytest.raises(ValueError, match="it has m1, m2"):
        read_view(tmp_path / "two.slp")
    slp(tmp_path / "one.slp", SEEN_BY, tracked=False)
    same(read_view(tmp_path / "one.slp"))


def test_labels_replace_predictions(tmp_path):
    slp(tmp_path / "both.slp", SEEN_BY, labelled=(1,))
    for who, name in enumerate(WHO):
        track = read_view(tmp_path / "both.slp", name)
        np.testing.assert_allclose(track.image[[0, 2]], IMAGE[who][[0, 2]])
        np.testing.assert_allclose(track.image[1], IMAGE[who, 1] + 5)
        assert (track.confidence[1, :2] == 1.0).all()


def test_sleaps_tables(tmp_path):
    sleap_csv(tmp_path / "two.csv", SEEN_BY)
    for who, name in enumerate(WHO):
        same(read_view(tmp_path / "two.csv", name), who)
    sleap_csv(tmp_path / "one.csv", SEEN_BY, tracks=("",), empty=True)
    same(read_view(tmp_path / "one.csv"))
    sleap_csv(tmp_path / "untracked.csv", SEEN_BY, tracks=("", ""))
    says = "line 3: point base of frame 0 stands in line 2 too: instances without a track"
    with pytest.raises(ValueError, match=says):
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


@pytest.mark.parametrize(
    "arrays, says",
    [
        ({"boxes": CO}, "no array pred_tracks or tracks; it has boxes: save as numpy.savez"),
        ({"pred_tracks": CO[..., :1]}, r"pred_tracks has shape \(3, 3, 1\): needs \(frames, points, 2\) px"),
        ({"pred_tracks": CO, "pred_visibility": 9.0 * SEEN - 4}, "logit"),
        ({"pred_tracks": CO, "pred_visibility": SEEN[:2]}, r"\(2, 3\), which does not fit 3 frames of 3 points"),
        ({"pred_tracks": CO, "names": "tip"}, "1 names, but pred_tracks has shape"),
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
        ("frame,point,x,y\n0,a,143_250,2\n", "line 2, column x: '143_250' is not a finite number"),
        ("# 3D point list with one line of data:\n0 a 1 2\n", "COLMAP's points3D.txt holds no points of images"),
        ("frame point x y\n0 a 1 2\n", "no column point, x, y: separate columns by , or ; or tabs, not spaces"),
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


def test_views_of_different_packages_go_together_by_name(tmp_path, ask, ask_json):
    """Of the demonstrator one frame, labelled by hand; of the learner three."""
    frame_of_pandas(SEEN_BY, True, True, "number").iloc[:1].to_csv(tmp_path / "l.csv")
    np.savez(tmp_path / "r.npz", pred_tracks=CO[:1], names=PARTS)
    sleap_csv(tmp_path / "own.csv", SEEN_BY)
    slp(tmp_path / "R.slp", SEEN_BY)
    paths = {"l": tmp_path / "l.csv", "r": tmp_path / "r.npz", "L": tmp_path / "own.csv", "R": tmp_path / "R.slp"}
    tracked = read_files(paths, {"l": "m1", "L": "m2", "R": "m2"})
    assert tracked.frames == (0, 1, 4) and tracked.points == PARTS
    views = tracked.views()
    np.testing.assert_allclose(views.demo_left, np.broadcast_to(IMAGE[0, :1], (3, 3, 2)))
    np.testing.assert_allclose(views.own_right, IMAGE[1])
    words = [word for view in VIEWS for word in (option(VIEW_NAMES[view]), paths[view])]
    assert ask("evaluate", *words)[0] == 2
    status, told = ask_json("evaluate", *words, "--demonstrator", "m1", "--learner", "m2")
    assert status == 1 and [frame["frame"] for frame in told["frames"]] == [0, 1, 4]  # three points are too few
    status, _, err = ask("evaluate", paths["R"])
    assert status == 2 and "by --demo-left, --demo-right, --own-left, --own-right" in err


@pytest.mark.parametrize(
    "name, says",
    [
        ("t_full.pickle", ".pickle files are not read: DeepLabCut's results are in the .h5 and .csv beside it"),
        ("t.mat", "save it as CSV, frame,point,x,y,confidence"),
        ("t.c3d", "those are .csv, .tsv, .txt, .h5, .hdf5, .slp, .npz, .npy"),
    ],
)
def test_other_formats_are_refused_with_the_conversion(tmp_path, ask, name, says):
    (tmp_path / name).write_bytes(struct.pack("d", 1.0))
    words = [word for view in VIEWS for word in (option(VIEW_NAMES[view]), tmp_path / name)]
    status, out, err = ask("evaluate", *words)
    assert status == 2 and not out and err.count("\n") == 1 and name in err and says in err


@pytest.mark.parametrize("name", ["t.h5", "f.h5", "a.h5", "s.slp", "s.csv", "d.csv", "n.npz", "n.npy", "p.csv"])
def test_a_damaged_file_is_read_or_named(tmp_path, name):
    """Cut off anywhere, or with some bytes changed."""
    pytest.importorskip("tables"), pytest.importorskip("h5py")
    path, rng = tmp_path / name, np.random.default_rng(0)
    {
        "t.h5": lambda: frame_of_pandas(SEEN_BY, True, True, "number").to_hdf(path, key="k", format="table"),
        "f.h5": lambda: frame_of_pandas(SEEN_BY, True, True, "levels").to_hdf(path, key="k", format="fixed"),
        "a.h5": lambda: analysis(path, SEEN_BY),
        "s.slp": lambda: slp(path, SEEN_BY),
        "s.csv": lambda: sleap_csv(path, SEEN_BY),
        "d.csv": lambda: frame_of_pandas(SEEN_BY, True, False, "levels").to_csv(path),
        "n.npz": lambda: np.savez(path, pred_tracks=CO[None], pred_visibility=SEEN[None], names=PARTS),
        "n.npy": lambda: np.save(path, CO[None]),
        "p.csv": lambda: path.write_text("frame;point;x;y\n0;tip;1,5;2\n1;tip;1,25;2\n"),
    }[name]()
    whole = path.read_bytes()
    for k in range(60):
        damaged = bytearray(whole[: rng.integers(1, len(whole))] if k % 2 else whole)
        for at in rng.integers(len(damaged), size=0 if k % 2 else 1 + k):
            damaged[at] = rng.integers(256)
        path.write_bytes(damaged)
        try:
            read_view(path, "m1")
        except ValueError as error:
            assert str(error).startswith(f"{path}: ") and "\n" not in str(error)


def named_files(words):
    return [Path(word) for word in words if re.search(r"\.\w+$", word) and word != "tags.csv"]


def write_as_named(path, images):
    """Write a file of one view, in the format that its name implies; some hold two arms."""
    stem, *name = path.name.split(".")[0].rsplit("_", 2)
    view = view_of("_".join(name))
    image = np.stack([images[view], images[view] + 9])[:, None]
    if view in "LR":
        image = image[::-1]
    who, several = ("left_arm", "right_arm"), stem == "both"
    seen = Seen(image, np.full(image.shape[:3], 0.9), np.array([0]), tuple(f"p{k}" for k in range(12)), who)
    if not several:
        seen = replace(seen, image=images[view][None, None], sure=seen.sure[:1], who=("",))
    if path.suffix == ".slp":
        slp(path, seen)
    elif path.name.endswith(".analysis.h5"):
        analysis(path, seen)
    elif several:
        sleap_csv(path, seen)
    elif path.suffix in (".npz", ".npy"):
        named = {"pred_tracks": seen.image[0][None], "names": seen.parts}
        np.savez(path, **named) if path.suffix == ".npz" else np.save(path, named["pred_tracks"])
        path.with_suffix(".txt").write_text("\n".join(seen.parts))
    elif path.suffix == ".png":
        import cv2
        from tags import picture_of

        from viewimit.sensing.detection import Fiducials

        dictionary = Fiducials("APRILTAG_36h11").dictionary
        cv2.imwrite(str(path), picture_of(dictionary, dict(enumerate(images[view])), shape=(1920, 2560)))
    elif stem == "keypoints":
        lines = [f"{name};{x:.3f};{y:.3f}".replace(".", ",") for name, (x, y) in zip(seen.parts, images[view])]
        path.write_text("\n".join(["name;x;y", *lines]))
    else:
        collected = stem == "CollectedData"
        frame = frame_of_pandas(seen, False, not collected, "path" if collected else "number")
        if path.suffix == ".csv":
            frame.to_csv(path)
        else:
            frame.to_hdf(path, key="df_with_missing", format="fixed" if collected else "table", mode="w")


def test_the_documented_commands_for_trackers_run(tmp_path, monkeypatch, ask_json):
    for package in ("h5py", "tables", "cv2"):
        pytest.importorskip(package)
    page = ROOT.joinpath("docs/how-to/tracks.md").read_text()
    section = page.partition("## What trackers write")[2].partition("\n## ")[0]
    (block,) = re.findall(r"^```text\n(.*?)^```", section, re.DOTALL | re.MULTILINE)
    lines = [shlex.split(line)[1:] for line in block.splitlines()]
    points, images = np.random.default_rng(6).uniform((-0.4, -0.3, 2.0), (0.4, 0.3, 2.6), (12, 3)), {}
    for view, (eye, turned) in zip(VIEWS, ((-0.05, 0.0), (0.05, 0.0), (-0.05, 0.2), (0.05, 0.2))):
        x, y, z = points[:, 0] - eye + turned * points[:, 1], points[:, 1], points[:, 2]
        images[view] = np.stack([1280 + 2400 * x / z, 960 + 2400 * y / z], -1)
    monkeypatch.chdir(tmp_path)
    written = [path for words in lines for path in named_files(words)]
    assert len(lines) == 5 and len(written) == 16
    for words in lines:
        for path in named_files(words):
            write_as_named(path, images)
        status, told = ask_json(*words)
        assert status == 0
        if words[0] == "evaluate":
            (frame,) = told["frames"]
            names = [int(name.lstrip("p")) for name in frame["usable"]]
            assert len(names) >= 9
            for view in VIEWS:
                np.testing.assert_allclose(frame["seen"][VIEW_NAMES[view]], images[view][names], atol=0.4)


COLMAP = """# Image list with two lines of data per image:
#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME
#   POINTS2D[] as (X, Y, POINT3D_ID)
# Number of images: 3, mean observations per image: 2
1 0.85 0.17 -0.49 0.07 -0.6 1.7 1.4 1 demo_right.png
2362.39 248.498 58396 1784.7 268.254 59027
2 0.85 0.17 -0.49 0.07 -0.6 1.7 1.4 1 empty.png

3 0.85 0.17 -0.49 0.07 -0.6 1.7 1.4 1 demo_left.png
1190.83 663.957 23056 10.5 20.25 -1 1258.77 640.354 59070
"""


@pytest.mark.parametrize("text", [COLMAP, COLMAP.partition("mean observations per image: 2\n")[2]])
def test_colmaps_images_are_refused_with_a_command_that_writes_the_points_of_one(tmp_path, text):
    (tmp_path / "images.txt").write_text(text)
    with pytest.raises(ValueError, match="images.txt is not read, as it holds all views") as refused:
        read_view(tmp_path / "images.txt")
    command = str(refused.value).rpartition(" both arms: ")[2].replace("python", sys.executable, 1)
    subprocess.run(command, shell=True, cwd=tmp_path, check=True)
    (written,) = tmp_path.glob("*.csv")
    track = read_view(written)
    assert track.points == ("23056", "59070") and track.image[0].tolist() == [[1190.83, 663.957], [1258.77, 640.354]]
