"""Read lenses from calibration files: ROS's camera_info, OpenCV's FileStorage, Kalibr's camchain, Anipose's TOML.

A file is read into plain mappings. Each mapping that has a camera matrix, by one of its usual names, is a camera; two
in one mapping, as K1 and K2, are two cameras. Of YAML the part that these tools write is read: blocks by indentation,
and lists and mappings in brackets.
"""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..geometry.arrays import Floats
from ..geometry.distortion import LensDistortion
from .files import MEGABYTE, parse_toml, read_bytes

MATRICES = "cameramatrix|intrinsicmatrix|intrinsicsmatrix|intrinsics|intrinsic|matrix|mtx|k|m"
DISTORTIONS = "dist(?:ortions?)?(?:coefficients?|coeffs?|coefs?|params|parameters|vector)?|d"
SIDES = "left|right|l|r|0|1|2"
KEY = re.compile(rf"(?:cam|camera)?({SIDES})?(?:({MATRICES})|({DISTORTIONS}))({SIDES})?")
NAMES = "name", "camera_name", "cam_name"
SIZES = "resolution", "size", "imagesize", "imgsize"
MODELS = (
    "plumbbob", "radtan", "pinhole", "pinholeradtan", "none", "brown", "brownconrady", "opencv", "rationalpolynomial",
    "",
)  # fmt: skip
MODEL_KEYS = "distortionmodel", "cameramodel", "model"
FISHEYE = re.compile("fisheye|equidist|kannala|^kb")
OTHER_MODEL = re.compile(f"{FISHEYE.pattern}|equisolid|stereographic|omni|^mei$|ucm|unified|doublesphere|^ds$|fov|ocam")
COUNTS = 2, 4, 5  # of coefficients that may be given
NUMBERS = "FX,FY,CX,CY,K1,K2,P1,P2,K3"
BEYOND = 0.1  # of the points' extent, by which a lens's centre lies outside before it is mentioned
N_COEFFICIENTS = 5  # k1, k2, p1, p2, k3
MAX_SKEW = 1e-3  # of the focal length
UNDISTORT = "remove the distortion from the table: points = cv2{}.undistortPoints(points, K, D, P=K)"
BY_TOOL = "remove the distortion from the table with the tool that has calibrated it"
QUOTED = r"(?:\"[^\"]*\"|'[^']*')"
KEYED = rf"(?:(?:{QUOTED}|[^\[\]{{}},:\"'][^\[\]{{}},:]*)\s*:\s*)?"
TOKEN = re.compile(rf"\s*([\[\]{{}},]|{KEYED}{QUOTED}(?!\s*:)|[^\[\]{{}},]+)")  # in brackets


@dataclass(frozen=True)
class CalibratedLens:
    """A lens as calibrated."""

    focal: tuple[float, float]  # px
    centre: tuple[float, float]  # px
    coefficients: tuple[float, ...] | None  # k1, k2, and perhaps p1, p2, k3; None if they are not known
    size: tuple[float, float] | None = None  # width and height of its pictures [px]

    def straightened(self, image: Floats, camera: str) -> Floats:
        """Return an image, (..., 2) px, without its distortion. Raises ValueError that names the camera."""
        by = LensDistortion.of(*(self.coefficients or (0.0, 0.0)))
        on_plane = (image - self.centre) / self.focal
        found = by.undistorted(on_plane)
        folded = np.isnan(found).any(-1) & np.isfinite(on_plane).all(-1)
        if folded.any():
            farthest = np.linalg.norm(on_plane[folded], axis=-1).max()
            raise ValueError(
                f"the lens shows nothing from {by.radial.max_distorted_radius:.3g} focal lengths on, where it folds "
                f"its image; a point of the {camera} camera is {farthest:.3g} from the centre"
            )
        return found * self.focal + self.centre

    def doubts(self, points: Floats) -> Iterator[str]:
        """Yield what speaks against it, given the points of its images, (N, 2) px."""
        points = points[np.isfinite(points).all(-1)]
        if not len(points):
            return
        low, high, centre = points.min(0), points.max(0), np.array(self.centre)
        size = 2 * centre if self.size is None else np.array(self.size)
        if (high > size * (1.0 if self.size else 1 + BEYOND)).any():
            made = "of" if self.size else "of about"
            yield (
                f"points lie as far as {high[0]:.0f},{high[1]:.0f}, and the lens is {made} pictures of "
                f"{size[0]:.0f} x {size[1]:.0f} px: calibrate it at the size of the tracked pictures"
            )
            return
        margin = BEYOND * (high - low)
        before, after = centre < low - margin, centre > high + margin
        sides = [word for word, is_so in zip(("right of", "below", "left of", "above"), (*before, *after)) if is_so]
        if sides:
            yield (
                f"all points lie {' and '.join(sides)} the lens's centre, {centre[0]:g},{centre[1]:g}: "
                "is it calibrated at another picture size?"
            )


def read_lenses(path: Path) -> dict[str, CalibratedLens]:
    """Read the lens of each camera in a calibration file, by the camera's name, in the file's order.

    Raises OSError, or ValueError that names the file and the camera.
    """
    content = read_bytes(path, MEGABYTE)
    try:
        fields = _parsed(path, content)
    except (msgspec.MsgspecError, ElementTree.ParseError, ValueError, RecursionError) as error:
        raise ValueError(f"{path}: not a calibration that is read: {error}") from None
    found: dict[str, CalibratedLens] = {}
    try:
        for name, lens in _cameras(fields, path.stem, {}):
            found[name if name not in found else f"{name}-{len(found)}"] = lens
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not found:
        raise ValueError(
            f"{path}: it has no camera matrix: give a camera_info of ROS, a FileStorage of OpenCV, a camchain of "
            "Kalibr or a calibration of Anipose"
        )
    return found


def _parsed(path: Path, content: bytes) -> Any:
    kind = path.suffix.lower()
    if kind == ".toml":
        return parse_toml(content)
    text = content.decode("utf-8-sig")
    if text.lstrip().startswith("<"):
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise ValueError("it defines entities")
        return _of_element(ElementTree.fromstring(text))
    if kind == ".json":
        return msgspec.json.decode(text)
    return _yaml(text)


def _cameras(fields: Any, name: str, above: Mapping[str, Any]) -> Iterator[tuple[str, CalibratedLens]]:
    """Yield the cameras in nested fields. above: fields that hold for all below them, by their plain names."""
    if isinstance(fields, list):
        for k, each in enumerate(fields):
            yield from _cameras(each, f"{name}{k}", above)
    if not isinstance(fields, Mapping):
        return
    known = {**above, **{_plain(key): value for key, value in fields.items() if not isinstance(value, Mapping)}}
    cameras: dict[str, dict[str, Any]] = {}  # of this mapping, by their side
    for key, value in fields.items():
        if (match := KEY.fullmatch(_plain(key))) and _numbers(value) is not None:
            first, matrix, _, last = match.groups()
            cameras.setdefault(first or last or "", {}).setdefault("matrix" if matrix else "distortion", value)
    with_matrix = {side: each for side, each in cameras.items() if "matrix" in each}
    own = next((fields[key] for key in NAMES if isinstance(fields.get(key), str)), None)
    name = own or name
    for side, each in with_matrix.items():
        yield side or name, _lens(f"camera {side or name}", each["matrix"], each.get("distortion"), known)
    for key, value in fields.items() if not with_matrix else ():
        yield from _cameras(value, str(key), known)


def _lens(name: str, matrix: Any, distortion: Any, known: Mapping[str, Any]) -> CalibratedLens:
    if model := _other_model(known):
        remedy = UNDISTORT.format(".fisheye") if FISHEYE.search(_plain(model)) else BY_TOOL
        raise ValueError(f"{name}: its model is {model!r}, not OpenCV's usual one: {remedy}")
    values = _numbers(matrix) or []
    if len(values) == 9:
        fx, skew, cx, *_, fy, cy = values[:6]
        if abs(skew) > MAX_SKEW * abs(fx) or [values[3], *values[6:]] != [0, 0, 0, 1]:
            raise ValueError(f"{name}: its matrix is not [fx 0 cx; 0 fy cy; 0 0 1]; MATLAB's is transposed")
    elif len(values) == 4:  # Kalibr's
        fx, fy, cx, cy = values
    else:
        raise ValueError(f"{name}: a camera matrix has 9 numbers, or 4 (fx, fy, cx, cy), not {len(values)}")
    if not (min(fx, fy) > 0 and np.isfinite([fx, fy, cx, cy]).all()):
        raise ValueError(f"{name}: focal lengths of {fx:g} and {fy:g} px are none of a lens")
    coefficients = None if distortion is None else _numbers(distortion) or [0.0]
    if coefficients is not None and len(coefficients) == 3:
        raise ValueError(f"{name}: are its 3 coefficients k1, k2, p1 or k1, k2, k3? Write k1, k2, p1, p2, k3")
    if coefficients is not None and any(coefficients[N_COEFFICIENTS:]):
        raise ValueError(f"{name}: it has {len(coefficients)} coefficients of distortion: {UNDISTORT.format('')}")
    size = next((_numbers(known[key]) for key in SIZES if key in known), None)
    pair = [known.get(f"image{side}", known.get(side)) for side in ("width", "height")]
    size = _numbers(pair) if size is None or len(size) != 2 else size
    k = None if coefficients is None else tuple((*coefficients[:N_COEFFICIENTS], 0.0)[: max(len(coefficients), 2)])
    return CalibratedLens((fx, fy), (cx, cy), k and k[:N_COEFFICIENTS], None if size is None else (size[0], size[1]))


def _other_model(known: Mapping[str, Any]) -> str | None:
    """What says that the lens is a fisheye, or of another model than OpenCV's usual one; None if nothing does."""
    for key, value in known.items():
        text = _plain(value)
        if ("fisheye" in key or key == "xi") and value and text not in ("false", "no", "0", "none"):
            return key
        if not isinstance(value, str):
            continue
        if key in MODEL_KEYS and text not in (*MODELS, "false"):
            return value
        if re.search("model|type|projection", key) and OTHER_MODEL.search(text):
            return value
    return None


def _plain(key: Any) -> str:
    """A key without what tells spellings apart."""
    return re.sub(r"[\W_]", "", str(key)).lower()


def _numbers(value: Any) -> list[float] | None:
    """The numbers of a matrix or a list, row by row; None if it is something else."""
    if isinstance(value, Mapping):
        return _numbers(value.get("data"))
    if not isinstance(value, list):
        return None
    rows = [_numbers(each) if isinstance(each, list) else [each] for each in value]
    found = [float(one) for row in rows for one in row or [None] if type(one) in (int, float)]
    return found if len(found) == sum(len(row or [None]) for row in rows) else None


def _of_element(element: ElementTree.Element) -> Any:
    """An element of OpenCV's XML as a mapping, a list or a value."""
    if not len(element):
        values = [_scalar(word) for word in (element.text or "").split()]
        return values[0] if len(values) == 1 and element.tag != "data" else values
    return {child.tag: _of_element(child) for child in element}


def _yaml(text: str) -> Any:
    """The mappings and lists of YAML. Raises ValueError that names the line."""
    lines: list[tuple[int, str, int]] = []  # indentation, text, number
    pending = ""
    for number, raw in enumerate(text.expandtabs().splitlines(), 1):
        line = re.sub(r"(^|\s)#.*", "", raw).rstrip()
        if not line.strip() or line.startswith(("%", "---", "...")):
            continue
        line = f"{pending} {line.strip()}" if pending else line
        pending = line if sum(map(line.count, "[{")) > sum(map(line.count, "]}")) else ""
        if not pending:
            line = re.sub(r"([:-]\s+)!\S+", r"\1", line)  # a tag, such as !!opencv-matrix
            lines.append((len(line) - len(line.lstrip()), line.strip(), number))
    if pending:
        raise ValueError("a bracket is not closed")
    value, end = _block(lines, 0) if lines else ({}, 0)
    if end < len(lines):
        raise ValueError(f"line {lines[end][2]} is not understood: {lines[end][1][:40]!r}")
    return value


def _block(lines: list[tuple[int, str, int]], at: int) -> tuple[Any, int]:
    """The list or mapping that begins at a line, and the first line after it."""
    if lines[at][1][0] in "[{":
        return _flow(lines[at][1]), at + 1
    indent, found = lines[at][0], []
    in_list = lines[at][1].startswith("-") and not isinstance(_scalar(lines[at][1]), float)
    while at < len(lines) and lines[at][0] == indent:
        _, text, number = lines[at]
        if in_list != bool(re.match(r"-(\s|$)", text)):
            break
        found_line = re.fullmatch(r"()-\s*(.*)" if in_list else r"(.*?):(?:\s+(.*))?", text)
        if found_line is None:
            raise ValueError(f"line {number} is not understood: {text[:40]!r}")
        key, rest = found_line[1].strip(), (found_line[2] or "").strip()
        nests = in_list and re.match(r"-\s|[^\[\]{}\"']*:(\s|$)", rest)
        after, next_text, _ = lines[at + 1] if at + 1 < len(lines) else (-1, "", 0)
        deeper = after > indent or (not in_list and after == indent and re.match(r"-(\s|$)", next_text))
        if nests:
            lines[at] = indent + len(text) - len(rest), rest, number
            value, at = _block(lines, at)
        elif not rest and deeper:
            value, at = _block(lines, at + 1)
        else:
            value, at = _flow(rest), at + 1
        found.append((key.strip("\"'"), value))
    return ([value for _, value in found] if in_list else dict(found)), at


def _flow(text: str) -> Any:
    """A value in a line."""
    if text[:1] not in ("[", "{"):
        return _scalar(text)
    tokens = [token.strip() for token in TOKEN.findall(text)]
    value, end = _bracket(tokens, 0)
    if end != len(tokens):
        raise ValueError(f"{text[:40]!r} is not understood")
    return value


def _bracket(tokens: list[str], at: int) -> tuple[Any, int]:
    """The list or mapping in brackets that begins at a token, and the first token after it."""
    found: list[tuple[str, Any]] = []
    is_list, at = tokens[at] == "[", at + 1
    while at < len(tokens) and tokens[at] not in "]}":
        key, _, rest = ("", "", tokens[at]) if is_list else map(str.strip, tokens[at].partition(":"))
        nested = at + (not rest)
        is_nested = tokens[nested : nested + 1] in (["["], ["{"])
        value, at = _bracket(tokens, nested) if is_nested else (_scalar(rest), at + 1)
        found.append((key.strip("\"'"), value))
        at += tokens[at : at + 1] == [","]
    if tokens[at : at + 1] != ["]" if is_list else "}"]:
        raise ValueError(f"{' '.join(tokens)[:40]!r} is not understood")
    return ([value for _, value in found] if is_list else dict(found)), at + 1


def _scalar(text: str) -> Any:
    if text[:1] in ("'", '"'):
        return text[1:-1]
    try:
        return float(text)
    except ValueError:
        return {"true": True, "false": False}.get(text.lower(), text)


def numbers_in(text: str) -> tuple[float, ...] | None:
    """Return finite numbers that are separated by commas; None for other text."""
    try:
        found = tuple(float(word) for word in text.split(","))
    except ValueError:
        return None
    return found if np.isfinite(found).all() else None


def lenses_of(text: str) -> dict[str, CalibratedLens]:
    """Return lenses by their cameras' names, as a text says them: numbers, a file, or a camera of it.

    Raises OSError, ValueError."""
    numbers = numbers_in(text)
    if numbers is not None:
        if len(numbers) - 4 not in (0, *COUNTS):
            raise ValueError(f"needs {NUMBERS}, of which K1 … may be left out, such as 600,600,320,240, got {text!r}")
        if min(numbers[:2]) <= 0:
            raise ValueError(f"focal lengths must be more than 0, got {text!r}")
        return {"": CalibratedLens((numbers[0], numbers[1]), (numbers[2], numbers[3]), numbers[4:] or None)}
    path, _, camera = text.partition("#") if not Path(text).exists() else (text, "", "")
    if not Path(path).exists() and "," in path:
        raise ValueError(f"needs {NUMBERS}, such as 600,600,320,240, or a file, got {text!r}")
    found = read_lenses(Path(path))
    if camera and camera not in found:
        raise ValueError(f"{path} has no camera {camera!r}; there are {', '.join(found)}")
    return {camera: found[camera]} if camera else found
