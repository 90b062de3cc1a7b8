"""Tracked points from files, one reader a format; all in pixels, (0, 0) at the picture's upper left or in the middle of
its first pixel, which makes no difference as long as all views agree.

What is not read is refused with what converts it.
"""

from collections.abc import Mapping
from pathlib import Path

from ...estimation.views import VIEWS, view_of
from .arrays import opened, read_arrays
from .deeplabcut import find_table, read_deeplabcut_csv, read_deeplabcut_h5
from .sleap import read_sleap_analysis, read_sleap_csv, read_slp
from .text import Table, colmap_kind, column_names, converting, read_plain, read_tidy, write_tidy
from .track import Row, Track, TrackedPoints, together

__all__ = ["Row", "Track", "TrackedPoints", "read_files", "read_tidy", "read_view", "write_tidy"]

READ = ".csv, .tsv, .txt, .h5, .hdf5, .slp, .npz, .npy"
RESULTS = "DeepLabCut's results are in the .h5 and .csv beside it"
TENSORS = "save it by numpy.savez('tracks.npz', pred_tracks=tracks.cpu(), pred_visibility=visibility.cpu(), names=[…])"
MODEL = (
    "of COLMAP: colmap model_converter --output_type TXT, and then images.txt, image by image, as its own error says"
)
CONVERT = {
    ".pickle": RESULTS,
    ".pkl": RESULTS,
    ".mat": "save it as CSV, frame,point,x,y,confidence, by MATLAB's writetable(…)",
    ".xlsx": "save the sheet as CSV",
    ".xls": "save the sheet as CSV",
    ".ods": "save the sheet as CSV",
    ".json": "write its keypoints as CSV, frame,point,x,y,confidence; of SLEAP, save as .slp",
    ".nwb": "convert it by sleap-io: sio convert tracks.nwb -o tracks.slp",
    ".pt": TENSORS,
    ".pth": TENSORS,
    ".parquet": "pandas.read_parquet(…).to_csv(…)",
    ".feather": "pandas.read_feather(…).to_csv(…)",
    ".gz": "unpack it",
    ".zip": "unpack it",
    ".bin": MODEL,
    ".db": "COLMAP: write its matched keypoints as CSV, point,x,y",
    **dict.fromkeys(
        (".mp4", ".avi", ".mov", ".mkv", ".png", ".jpg", ".jpeg"), "detect its points first: viewimit detect"
    ),
}


def read_files(paths: Mapping[str, Path], individuals: Mapping[str, str] | None = None) -> TrackedPoints:
    """One file a view, of any format each. individuals: by view, whose points to take of files that hold several. Views
    are called by their full names, demo_left, or by the paper's, l.

    Raises ValueError that names the file and what is wrong there; OSError.
    """
    files = {view_of(name): path for name, path in paths.items()}
    whose = {view_of(name): individual for name, individual in (individuals or {}).items()}
    return together({view: read_view(files[view], whose.get(view)) for view in VIEWS})


def read_view(path: Path, individual: str | None = None) -> Track:
    """A file of one view, as `read_files`."""
    suffix = path.suffix.lower()
    if suffix in CONVERT:
        raise ValueError(f"{path}: {suffix} files are not read: {CONVERT[suffix]}")
    if suffix in (".h5", ".hdf5", ".slp"):
        track = _of_hdf5(path, individual)
    elif suffix in (".npz", ".npy"):
        track = read_arrays(path)
    elif suffix in (".csv", ".tsv", ".txt", ""):
        track = _of_text(path, individual)
    else:
        raise ValueError(
            f"{path}: {suffix} files are not read; those are {READ}: save it as CSV, frame,point,x,y,confidence"
        )
    return track.require_pixels(str(path)).seen()


def _of_hdf5(path: Path, individual: str | None) -> Track:
    with opened(path) as file:
        if "instances" in file and "metadata" in file:
            return read_slp(path, file, individual)
        if "track_occupancy" in file or "tracks" in file:
            return read_sleap_analysis(path, file, individual)
        table = find_table(file)
        if table is None:
            raise ValueError(f"{path}: neither DeepLabCut's table nor SLEAP's tracks are in it; export them as CSV")
        return read_deeplabcut_h5(path, table, individual)


def _of_text(path: Path, individual: str | None) -> Track:
    _, heading = next(Table(path).lines())
    if kind := colmap_kind(",".join(heading)):
        raise ValueError(f"{path}: {converting(path, kind)}")
    if heading[0] == "scorer":
        return read_deeplabcut_csv(path, individual)
    if "frame_idx" in heading and {"track", "instance.score"} & set(heading):
        return read_sleap_csv(path, individual)
    if "view" in column_names(heading):
        raise ValueError(f"{path}: a table of all four views: give it alone, without --demo-left and the like")
    return read_plain(path)
