"""What stands in the head of every page: no icon, and the ways to lab, lessons, class and documentation of the site."""

from typing import Any

from sphinx.application import Sphinx

VERBS = {"Play": "../index.html", "Learn": "../learn/index.html", "Teach": "teach/class.html", "Use": "index.html"}
NO_ICON = '<link rel="icon" href="data:,">'  # browsers ask the server's first folder for one otherwise


def verbs(page: str) -> str:
    """Return HTML of the four ways, from a page by its path without an ending."""
    up, here = "../" * page.count("/"), "Teach" if page.startswith("teach/") else "Use"
    links = (
        f'<a href="{up}{address}"{" aria-current=true" if name == here else ""}>{name}</a>'
        for name, address in VERBS.items()
    )
    return f'<nav class="verbs" aria-label="viewimit">{" ".join(links)}</nav>'


def _add(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    context["metatags"] = context.get("metatags", "") + NO_ICON
    context["theme_announcement"] = verbs(page)


def add_to(app: Sphinx) -> None:
    app.connect("html-page-context", _add)
