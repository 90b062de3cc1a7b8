"""The keys of the page, some of them named at the bottom of the left panel; H opens the help: what the page shows, in
reading order."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ..drawing.glossary import listed
from ..model.page_model import PageModel
from .panel import Layout


@dataclass(frozen=True)
class Key:
    """A key of the page."""

    cap: str  # on the key
    hotkey: Any  # of viser's HotkeyKey
    word: str  # what it does
    sentence: str  # the same, in viser's list of commands
    command: str
    hinted: bool = False  # named in the left panel too


KEYS = (
    Key("space", "space", "play", "Play or pause", "play", True),
    Key("→", "arrowright", "step", "Step: one motion", "step", True),
    Key("←", "arrowleft", "undo", "Undo: one motion back; at a start, what was before it", "undo"),
    Key("R", "R", "reset", "Reset to the start", "reset"),
    Key("N", "N", "next point", "Choose the next point", "next_point"),
    Key("G", "G", "goal", "Show the goal in L and R, or hide it", "goal"),
    Key("C", "C", "construct", "Build up, step by step, how the chosen point is recovered", "construction"),
    Key("V", "V", "view", "Fit the view", "fit_view"),
    Key("H", "H", "help", "Help", "help", True),
    Key("M", "M", "large", "Images large, then figures, then all as before", "next_larger"),
    Key("E", "E", "edit points", "Edit the points of both arms, or end that", "edit_points"),
    Key("B", "B", "best next", "Propose the point that would tell most; once more: place it", "best"),
    Key("Del", "delete", "remove point", "Remove the chosen point", "remove"),
    Key("⌫", "backspace", "the same", "Remove the chosen point, by Backspace", "remove"),
    Key("L", "L", "link", "A link to what the page shows, and the code that repeats it", "share"),
    Key("S", "S", "picture", "Save a picture of the panel chosen under Save", "save_picture"),
    Key("Esc", "escape", "close", "Close the help, or what is large, or let the see-through arm go", "dismiss"),
)


def keys(layout: Layout, model: PageModel) -> None:
    gui, card = layout.gui, None  # the open modal
    gui.add_html(f'<div class="vi-keys">{key_caps(key for key in KEYS if key.hinted)}</div>')
    for key in KEYS:
        _add_hotkey(layout, key)

    def show_help(model: PageModel) -> None:
        nonlocal card
        if card is not None:
            card.close()
            card = None
        if model.view.help:
            card = gui.add_modal("viewimit: what is seen here")
            with card:
                done = gui.add_button("Close")  # first, so that it has the focus and is in sight
                gui.add_html(help_html(key_caps(KEYS)))
            layout.queue.on_click(done, "help")

    layout.drawing(lambda model: (model.view.help,), show_help)


def _add_hotkey(layout: Layout, key: Key) -> None:
    call = layout.queue.commands[key.command]()
    entry = layout.gui.add_command(key.sentence, hotkey=key.hotkey)

    @entry.on_trigger
    async def _(_event) -> None:
        layout.queue.put(call)


def key_caps(keys: Iterable[Key]) -> str:
    return "".join(f"<span><kbd>{key.cap}</kbd> {key.word}</span> " for key in keys)


PARAGRAPHS = (
    ("Two robots, one pair of eyes.", "The stereo head is the learner's. It looks at the demonstrator (l, r), then at "
     "its own arm (L, R), and knows nothing but points in these four images: no model of an arm, no calibration."),
    ("Two views give a line.", "Click a point, or press N: where it lies in l puts it on a line in L; r gives "
     "a second line. The lines are computed as if both arms were in the same pose. A hollow diamond is where the "
     "lines put the point."),
    ("A wrong pose makes a conflict.", "Where the poses differ, no lines can fit all points. The misfit that "
     "remains, the arrows e from diamonds to dots, is the conflict; E is their mean square. An arrow is a "
     "contradiction, not a signpost. The grey ghost in L and R is the goal, which the learner does not know: "
     "only there do dots and diamonds meet. G hides it."),
    ("The conflict drives the arm.", "Play. The learner moves, learns what that changes in its images, and goes where "
     "E is smaller. The landscape shows E for all postures; the learner knows only its own path. Watch yourself first:"
     " it goes through 12 postures with nobody to imitate, and needs no probes then."),
    ("Touch it.", "Click the landscape: the learner starts there; with Look only a see-through arm shows the posture,"
     " and nothing moves. From these starts sends twenty learners. Click a curve: back to that moment. Undo takes back"
     " resets and presets, too."),
    ("Disturb it.", "Move the demonstrator at any time by its sliders or its hand, add noise, lose points, or take a"
     " preset that breaks the method. The strip under the scene says what the learner itself can "
     "tell, and beneath it what is true. A ? says what a number means."),
    ("Race two methods.", "The tab Duel sends a second, see-through learner from your learner's start, with another "
     "transfer and servo. Compare all transfers under the landscape; free all seven joints under Method."),
    ("Mark the arms yourself.", "Edit points, or E: where you click an arm, both have a point more. The strip says what"
     " a pixel of noise then costs at each joint, and Best next shows the place that would tell most, hollow until you"
     " take it. Save scene keeps the points in a file for <code>viewimit imitate --scene</code>."),
    ("Look with cameras.", "Camera images, under Display, shows both arms with coloured balls in rendered pictures."
     " A dot or filled diamond is a ball that was detected; faint ones are missing in another image, and no"
     " picture is taken on the way. Landscapes and experiments remain those of projected points."),
    ("Show it to a class.", "P, or <code>?present</code> in the address: larger letters, no controls, a ring about the "
     "pointer. What is true is hidden until T. For lessons with a class, start <code>viewimit class</code>."),
    ("Repeat the paper.", "The tab Experiments runs Figs. 7, 9 and 10 with what you have set here, judges them by the "
     "paper and hands you figure and data. Fig. 10 also follows a motion that you record or load in the tab Motions;"
     " See it shows both arms as it was imitated."),
)  # fmt: skip


METHODS = (("Transfers", TRANSFERS), ("Servos", SERVOS))


def help_html(keys: str) -> str:
    """For a modal. keys: what they are, as html."""
    texts = "".join(f"<p><b>{title}</b> {text}</p>" for title, text in PARAGRAPHS)
    note = (
        "<p class='vi-help-note'>Arms, rays, residuals in 3-D, the demonstrator's marks and the landscape are the "
        "simulation's truth, for the viewer only; no transfer or servo is given any of it.</p>"
    )
    methods = "".join(
        f"<p><b>{title}</b></p><dl>"
        + "".join(f"<dt>{m.title}</dt><dd>Assumes: {m.assumes} Fails: {m.limitations}</dd>" for m in methods.values())
        + "</dl>"
        for title, methods in METHODS
    )
    words = f'<p><b>What the numbers mean</b></p><div class="vi-entries">{listed()}</div>'
    return f'<div class="vi-help"><div class="vi-help-keys">{keys}</div>{texts}{methods}{words}{note}</div>'
