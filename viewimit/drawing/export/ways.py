"""The way from page to page: four verbs in the header of each, and what a page says of itself."""

from collections.abc import Mapping
from html import escape

from ... import __version__

VERBS = {
    "play": ("Play", "The lab: pose one robot, and watch the other copy it"),
    "learn": ("Learn", "Lessons of five to ten minutes"),
    "teach": ("Teach", "A class, plans and an exam"),
    "use": ("Use", "Documentation: your own robot, tracks, Python"),
    "workbench": ("Workbench", "Every setting, experiments and figures"),
}
SERVED = {"play": "/lab", "learn": "/lab/tour", "workbench": "/"}  # by `viewimit`
CREDITS = (
    "<p>The method is that of Y. Yoshikawa, M. Asada and K. Hosoda, “View-Based Imitation Learning by Conflict"
    " Resolution with Epipolar Geometry”, IROS 2001. This page computes it in your browser, as the Python library"
    f" viewimit {__version__} does (MIT licence). Cite the paper, and “viewimit {__version__}”.{{links}}</p>"
)


def site_ways(root: str) -> dict[str, str]:
    """Return the addresses by verb on a site that `viewimit site` has written. root: its address, as seen by a page."""
    return {
        "play": root or "./",
        "learn": f"{root}learn/",
        "teach": f"{root}docs/teach/class.html",
        "use": f"{root}docs/",
    }


def verbs(here: str, addresses: Mapping[str, str]) -> str:
    """Return the header's links as HTML; nothing if no other page has an address. here: the verb of this page."""
    if not set(addresses) - {here}:
        return ""
    links = "".join(
        f'<a href="{escape(addresses[verb])}" title="{about}"{" aria-current=page" if verb == here else ""}>{word}</a>'
        for verb, (word, about) in VERBS.items()
        if verb in addresses
    )
    return f'<nav class="ways" aria-label="Pages">{links}</nav>'


def credits(addresses: Mapping[str, str]) -> str:
    """Return who made the method and this page, how to cite them, and the article, if it has an address."""
    docs = addresses.get("use")
    links = "" if docs is None else f' <a href="{escape(docs)}method.html">The article</a> explains it.'
    return CREDITS.format(links=links)
