"""The help panel: what the page shows, in reading order, and its keys."""

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ...drawing.glossary import listed

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
