"""Models of COLMAP as text, which are not read: what converts the points of one of their images.

One file holds the images of all views, in two lines each, and names points by their place in space, so that only a
person knows which image is which view, and which points of the two arms are the same.
"""

from pathlib import Path

KINDS = {"# Image list": "images.txt", "# 3D point list": "points3D.txt", "# Camera list": "cameras.txt"}  # first lines
POSE, CELLS = 9, 10  # of an image: numbers, and its name behind them
COMMAND = (
    "python -c \"r = [s.split() for s in open('{file}') if s[0] != '#']; "
    "p = next(p for i, p in zip(r[::2], r[1::2]) if i[9] == 'demo_left.png'); print('point,x,y'); "
    "[print(p[k + 2], p[k], p[k + 1], sep=',') for k in range(0, len(p), 3) if p[k + 2] != '-1']\" > demo_left.csv"
)


def colmap_kind(first: str) -> str | None:
    """Which of its files begins with this line, if one does."""
    for start, kind in KINDS.items():
        if first.startswith(start):
            return kind
    return "images.txt" if _is_pose(first.split(maxsplit=POSE)) else None


def converting(path: Path, kind: str) -> str:
    """A sentence with the command."""
    if kind != "images.txt":
        return f"COLMAP's {kind} holds no points of images: take images.txt beside it"
    return (
        "COLMAP's images.txt is not read, as it holds all views; write the points of each of them, here of "
        "demo_left.png, as CSV, and give the same names to the same points of both arms: "
        f"{COMMAND.format(file=path)}"
    )


def _is_pose(cells: list[str]) -> bool:
    """An image's first line, where the heading was taken out."""
    if len(cells) != CELLS:
        return False
    try:
        return all(float(cell) == float(cell) for cell in cells[:POSE])
    except ValueError:
        return False
