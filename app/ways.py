"""The short header of every page: Play, Learn, Teach, Use, and Workbench where it is served; and who made this."""

from dataclasses import dataclass
from html import escape
from pathlib import Path

from viewimit import __version__

STYLES = Path(__file__).parent / "lab" / "view" / "ways.css"
VERBS = {  # by field: the word, and what is there
    "play": ("Play", "The lab: pose one robot, and watch the other copy it"),
    "learn": ("Learn", "Lessons of a few minutes"),
    "teach": ("Teach", "A class on its own devices, plans, exam items"),
    "use": ("Use", "The documentation: your own robot, tracked points, Python"),
    "workbench": ("Workbench", "The page for own robots, every method, and experiments"),
}
WHAT = "Here one robot copies the pose of another from image points alone."


@dataclass(frozen=True)
class Ways:
    """Where the verbs lead, as addresses that a page has as links; a verb without one is left out. Give `lab_page`,
    `lesson_page` and `class_pages` what `of_site` returns for the folder of a site as that page sees it ("" for the
    lab, "../" for lessons, "https://…/" for a file that is sent), or what `served` returns for the root of the page's
    own server. The page that is shown needs no address of its own: see `header`."""

    play: str | None = None
    learn: str | None = None
    teach: str | None = None
    use: str | None = None
    workbench: str | None = None

    @classmethod
    def of_site(cls, root: str) -> "Ways":
        """Return the ways in a site as `viewimit site` writes it. root: its folder, "" or ending in a slash."""
        places = "index.html", "learn/index.html", "docs/teach/class.html", "docs/index.html"
        return cls(*(root + place for place in places))

    @classmethod
    def served(cls, root: str, lesson: str) -> "Ways":
        """Return the ways in a server of the Workbench. root: its address, "./" or "../"; lesson: the first one's
        name."""
        return cls(play=f"{root}lab", learn=f"{root}lab/{lesson}", workbench=root)


def header(ways: Ways, here: str, with_about: bool = True) -> str:
    """Return the ways as HTML, the page's own verb, `here`, without a link; "" where there is no other. with_about:
    whether to add a "?" that says who made this, for pages without a help of their own."""
    parts = []
    for verb, (word, what) in VERBS.items():
        address = getattr(ways, verb)
        if verb == here:
            parts.append(f'<b aria-current="page">{word}</b>')
        elif address is not None:
            parts.append(f'<a class="to-{verb}" href="{escape(address)}" title="{escape(what)}">{word}</a>')
    if len(parts) == 1 and not with_about:
        return ""
    help_ = (
        '<button type="button" popovertarget="about" aria-label="What is this?">?</button>'
        f'<div id="about" popover><p>{WHAT}</p>{about(ways)}</div>'
    )
    return f'<nav class="ways" aria-label="Pages">{"".join(parts)}{help_ if with_about else ""}</nav>'


def about(ways: Ways) -> str:
    """Return who made this, under which licence, where it comes from, and how to cite it, as HTML."""
    folder = (ways.use or "").removesuffix("index.html")
    article, package = "", "viewimit"
    if ways.use is not None:
        article = f'<a href="{escape(folder)}method.html">The article</a> tells how it works. '
        package = f'<a href="{escape(folder)}index.html">viewimit</a>'
    return (
        f"<p>viewimit {__version__}, by the viewimit authors. MIT licence. It computes the method of “View-Based"
        " Imitation Learning by Conflict Resolution with Epipolar Geometry” (IROS 2001).</p>"
        f"<p>{article}The source comes with the Python package {package}.</p>"
        f"<p>To cite: The viewimit authors, <i>viewimit</i> {__version__}, software; with the paper above.</p>"
    )
