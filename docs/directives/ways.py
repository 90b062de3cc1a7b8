"""The header that all pages have, over each page of the documentation, and no icon."""

from typing import Any

from sphinx.application import Sphinx
from viewimit.app.ways import Ways, header

NO_ICON = '<link rel="icon" href="data:,">'  # browsers ask the server's first folder for one otherwise


def _add(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """The site's folder holds the documentation's; the theme's line for announcements takes the header."""
    here = "teach" if page.startswith("teach/") else "use"
    context["theme_announcement"] = header(Ways.of_site("../" * (page.count("/") + 1)), here)
    context["metatags"] = context.get("metatags", "") + NO_ICON


def add_to(app: Sphinx) -> None:
    app.connect("html-page-context", _add)
