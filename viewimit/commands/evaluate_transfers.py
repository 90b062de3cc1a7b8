"""What `evaluate` says of the transfers: how far each is off at points that it was not fitted to, and rectification."""

from collections.abc import Iterator

from ..analysis.leave_one_out import JUDGE, MAX_RATIO, LeaveOneOut


def told(found: LeaveOneOut) -> dict | None:
    """As JSON has it, px rms by transfer; None if nothing was predicted."""
    if not found.error_px:
        return None
    return {
        "error_px": dict(found.error_px),
        "rectified_px": None if found.rectified_px is None else dict(found.rectified_px),
        "rectified_ratio": found.ratio,
        "rectified_ratio_bound": found.ratio_bound,
        "predictions": found.predictions,
        "of_predictions": found.of_predictions,
        "frames": found.frames,
        "of_frames": found.of_frames,
        "sampled": found.sampled,
    }


def heading(found: dict) -> str:
    """Of the table below."""
    predictions, frames = (_of(found[what], found[f"of_{what}"]) for what in ("predictions", "frames"))
    sampled = ", evenly spaced" if found["sampled"] else ""
    plural = "" if found["of_frames"] == 1 else "s"
    return f"leave-one-out error, rms px: {predictions} predictions in {frames} frame{plural}{sampled}"


def rows(found: dict) -> Iterator[tuple[str, ...]]:
    """Names of the columns, then a row a transfer."""
    columns = [found["error_px"]] if found["rectified_px"] is None else [found["error_px"], found["rectified_px"]]
    yield ("transfer", "images as they are", "rectified")[: 1 + len(columns)]
    for name in found["error_px"]:
        yield name, *(f"{column[name]:.3g}" for column in columns)


def verdict(found: dict | None, rectified: bool) -> str | None:
    """Whether images are rectified, and why. None if that was not asked, or there is nothing to rectify."""
    if found is None or found["rectified_px"] is None:
        return "images rectified: their matches ask for it" if rectified else None
    how, ratio = "rectified" if rectified else "left as they are", found["rectified_ratio"]
    if ratio is None:
        large = "errors this large are of arms in different postures, or of magnified noise"
        return f"images {how}, as their matches ask; {large}"
    what = f"{JUDGE} is {ratio:.2g} times as far off if rectified, {found['rectified_ratio_bound']:.2g} at most"
    return f"images {how}: {what}; less than {MAX_RATIO:g} asks for it"


def _of(count: int, whole: int) -> str:
    return f"{count:,}" if count == whole else f"{count:,} of {whole:,}"
