"""Opens the page in a pseudo-language, each of whose texts is English in brackets; fails for what stands outside them.

VIEWIMIT_LOCALE=… LANGUAGE=… python tests/pseudo_language.py
"""

import re
import sys
from html.parser import HTMLParser

from quiet_page import Gui, QuietPage, Widget
from viewimit.app.model.choices import PRESETS
from viewimit.app.static import CONTENT, PAGE_JS, stylesheet

from viewimit.loop.settings import Settings

OPEN, CLOSE = "⟦", "⟧"
SPOKEN = {"aria-label", "title", "placeholder", "alt"}  # attributes that a visitor reads or hears
SILENT = {"style", "script", "math", "code", "kbd", "pre"}  # elements whose texts are the same in every language
SAME = {"px", "viewimit", "cond", "SVG", "PNG"}  # words that are, too
SAME |= {"epipolar", "linear", "rank", "projective"}  # names of transfers, by which commands and files call them
SAME |= {"panda", "iiwa", "verged", "toed", "facing", "flat"}  # and of scenes
NOT_SHOWN = {"icon", "mime_type", "color", "order"}  # properties of widgets
HIDDEN = {"vi-actions", "vi-session"}  # widgets that nobody sees, of JSON
WORD = re.compile(r"[^\W\d_]{2,}")


def outside(text):
    """What stands outside brackets."""
    depth, letters = 0, []
    for letter in text:
        depth += letter == OPEN
        letters.append(letter if depth == 0 else " ")
        depth -= letter == CLOSE
    return "".join(letters)


def foreign(text):
    """Words outside brackets, without symbols and what is the same in every language."""
    return [word for word in WORD.findall(outside(text)) if word.isascii() and word not in SAME]


class Read(HTMLParser):
    """What a piece of HTML says, and what its attributes say aloud."""

    def __init__(self, text):
        super().__init__()
        self.silent, self.said, self.aloud = 0, "", []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.silent += tag in SILENT
        self.aloud += [value for name, value in attrs if name in SPOKEN and value]

    def handle_endtag(self, tag):
        self.silent -= tag in SILENT

    def handle_data(self, data):
        self.said += "" if self.silent else f"{data}\n"


class RecordingWidget(Widget):
    """Keeps all that is ever written to it."""

    def __setattr__(self, name, value):
        super().__setattr__(name, value)
        keep(name, value)


class RecordingGui(Gui):
    """Keeps all texts that widgets are made with."""

    def __getattribute__(self, name):
        found = super().__getattribute__(name)
        if not name.startswith("add_"):
            return found

        def add(*values, **named):
            for field, value in (*((name, value) for value in values), *named.items()):
                keep(field, value)
            return found(*values, **named)

        return add

    def _add(self, label, **fields):
        self.widgets.append(RecordingWidget(label, **fields))
        return self.widgets[-1]


SEEN = {}  # all texts, in the order in which they were first seen


def keep(field, value):
    if isinstance(value, str) and field not in NOT_SHOWN and value not in HIDDEN and not value.startswith("{"):
        SEEN[value] = None
    elif isinstance(value, (list, tuple)):
        for one in value:
            keep(field, one)


ACTIONS = (
    "help", "help", "share", "share", "step", "next_point", "play", "play", "undo", "edit_points", "best", "dismiss",
    "dismiss", "rehearsal", "rehearsal", "duel", "step", "duel", "compare", "compare", "record", "record", "scene",
    "save_picture", "save_replay",
)  # fmt: skip
CALLS = (
    ("choose_point", "99"), ("link", "no=link"), ("session", "damaged"), ("run", "no"), ("unsaved", "storage"),
    ("show", "E"), ("restore",), ("switch", "look_only", True), ("posture", "40,-80"), ("dismiss",),
)  # fmt: skip


class Visit:
    """Does on the page what shows its texts."""

    def __init__(self):
        self.quiet = QuietPage(Settings.paper(start_deg=(30, -60)), shared="https://example.org", gui=RecordingGui())
        self.quiet.client.send_file_download = lambda *args, **options: None
        self.settle()

    def settle(self):
        self.quiet.tick(1.0)
        self.quiet.settle()
        self.quiet.tick(1.0)

    def call(self, name, *values):
        queue = self.quiet.page.queue
        queue.call(name, *values[: len(queue.commands[name].parsers)])
        self.settle()

    def choose_everything(self):
        """In each list the second choice: it stays, as the page understands it."""
        for widget in list(self.quiet.gui.widgets):
            options = vars(widget).get("options", ())
            if len(options) > 1 and widget.visible and not vars(widget).get("disabled"):
                widget.value = chosen = options[1]
                self.quiet.tell(widget)
                self.settle()
                assert widget.value == chosen, f"{chosen} of {widget.label} is refused"

    def go_through(self):
        for name in ACTIONS:
            self.call(name)
        for name, *values in CALLS:
            self.call(name, *values)
        for preset in PRESETS:
            if preset.settings.sensor == "projected" and len(preset.settings.joints or ()) <= 2:
                self.call("preset", preset.name)
                self.call("step")
        self.choose_everything()
        self.quiet.page.close()


def main():
    assert not re.search(r"(?<![\w.$])_\(", PAGE_JS), "a mark in the script that `translated` does not read"
    assert OPEN.encode("unicode_escape").decode() in PAGE_JS, "the script is not translated"
    Visit().go_through()
    assert len(SEEN) > 200, "too few texts were seen"
    found = {words for words in CONTENT.findall(stylesheet()) if foreign(words)}
    for text in SEEN:
        read = Read(text)
        found |= {line.strip() for line in outside(read.said).split("\n") if foreign(line)}
        found |= {words for words in read.aloud if foreign(words)}
    print("\n".join(sorted(found)))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
