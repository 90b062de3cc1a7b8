"""Read tracked points from files: CSV, numpy, DeepLabCut and SLEAP.

All coordinates are in pixels. (0, 0) may be the upper left corner of the picture or the centre of its first pixel, as
long as all views agree. A file of another format is refused with a message that says what converts it.
"""

from collections.abc import Mapping
from pathlib import Path

from ...estimation.views import VIEWS, view_of
from .arrays import open_hdf5, read_arrays
from .columns import Meaning, meaning_of
from .pose_trackers import (
    LEVELS,
    read_deeplabcut_csv,
    read_deeplabcut_h5,
    read_sleap_analysis,
    read_sleap_csv,
    read_slp,
)
from .text import Table, column_names, read_plain, read_tidy, refuse_colmap, write_tidy
from .track import Row, Track, TrackedPoints, combine_views

__all__ = ["Row", "Track", "TrackedPoints", "read_files", "read_tidy", "read_view", "write_tidy"]

READ = ".csv, .tsv, .txt, .h5, .hdf5, .slp, .npz, .npy"
RESULTS = "DeepLabCut's results are in the .h5 and .csv beside it"
TENSORS = "save it by numpy.savez('tracks.npz', pred_tracks=tracks.cpu(), pred_visibility=visibility.cpu(), names=[…])"
COLMAP = (
    "of COLMAP: colmap model_converter --output_type TXT, and then images.txt, image by image, as its own error says"
)
CONVERT = {
    **dict.fromkeys((".pickle", ".pkl"), RESULTS),
    **dict.fromkeys((".xlsx", ".xls", ".ods"), "save the sheet as CSV"),
    **dict.fromkeys((".pt", ".pth"), TENSORS),
    **dict.fromkeys((".gz", ".zip"), "unpack it"),
    **dict.fromkeys(
        (".mp4", ".avi", ".mov", ".mkv", ".png", ".jpg", ".jpeg"), "detect its points first: viewimit detect"
    ),
    ".mat": "save it as CSV, frame,point,x,y,confidence, by MATLAB's writetable(…)",
    ".json": "write its keypoints as CSV, frame,point,x,y,confidence; of SLEAP, save as .slp",
    ".nwb": "convert it by sleap-io: sio convert tracks.nwb -o tracks.slp",
    ".parquet": "pandas.read_parquet(…).to_csv(…)",
    ".feather": "pandas.read_feather(…).to_csv(…)",
    ".bin": COLMAP,
    ".db": "COLMAP: write its matched keypoints as CSV, point,x,y",
}


def read_files(paths: Mapping[str, Path], individuals: Mapping[str, str] | None = None) -> TrackedPoints:
    """Read one file for each view, each of any format. paths: files by view. Views have their full names, such as
    demo_left, or the paper's, such as l; individuals: by view, the individual to take from a file that holds several.
    Raises ValueError: names the file and the fault. Raises OSError."""
    files = {view_of(name): path for name, path in paths.items()}
    whose = {view_of(name): individual for name, individual in (individuals or {}).items()}
    return combine_views({view: read_view(files[view], whose.get(view)) for view in VIEWS}).require_pixels("")


def read_view(path: Path, individual: str | None = None) -> Track:
    """Read the file of one view. The format follows from the ending and the content. Raises as `read_files`."""
    suffix = path.suffix.lower()
    if suffix in CONVERT:
        raise ValueError(f"{path}: {suffix} files are not read: {CONVERT[suffix]}")
    if suffix in (".h5", ".hdf5", ".slp"):
        track = _read_hdf5(path, individual)
    elif suffix in (".npz", ".npy"):
        track = read_arrays(path)
    elif suffix in (".csv", ".tsv", ".txt", ""):
        track = _read_text(path, individual)
    else:
        raise ValueError(
            f"{path}: {suffix} files are not read; those are {READ}: save it as CSV, frame,point,x,y,confidence"
        )
    return track.require_pixels(str(path)).non_empty_frames()


def _read_hdf5(path: Path, individual: str | None) -> Track:
    with open_hdf5(path) as file:
        if "instances" in file and "metadata" in file:
            return read_slp(path, file, individual)
        if "track_occupancy" in file or "tracks" in file:
            return read_sleap_analysis(path, file, individual)
        table = next((group for group in file.values() if "pandas_type" in group.attrs), None)
        if table is None:
            raise ValueError(f"{path}: neither DeepLabCut's table nor SLEAP's tracks are in it; export them as CSV")
        return read_deeplabcut_h5(path, table, individual)


def _read_text(path: Path, individual: str | None) -> Track:
    table = Table(path)
    refuse_colmap(path, table.first)
    _, heading = next(table.lines())
    if heading[0] in LEVELS and not {Meaning.X, Meaning.Y} <= {*map(meaning_of, heading)}:
        return read_deeplabcut_csv(path, individual)
    if "frame_idx" in heading and {"track", "instance.score"} & set(heading):
        return read_sleap_csv(path, individual)
    if "view" in column_names(heading):
        raise ValueError(f"{path}: a table of all four views: give it alone, without --demo-left and the like")
    return read_plain(path)
