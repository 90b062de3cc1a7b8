"""What the learner itself says at the end of a run, and beside it the truth, which it cannot know."""

from collections.abc import Collection, Sequence

from .. import svg

LAYERS = ("learner", "truth")
ICONS = {
    "learner": '<circle cx="11" cy="11" r="8" class="vi-point"/>',
    "truth": '<path d="M11 1.5l9.5 9.5-9.5 9.5-9.5-9.5z" class="vi-amber"/>',
}
HEADS = {"learner": "The learner says", "truth": "Only you can see"}


def draw_verdict(says: Sequence[str], truth: Sequence[str], layers: Collection[str]) -> str:
    """HTML. says, truth: sentences, the first of each in bold."""
    boxes = [_box(kind, words) for kind, words in (("learner", says), ("truth", truth)) if kind in layers and words]
    return f'<div class="vi-verdict">{"".join(boxes)}</div>'


def _box(kind: str, words: Sequence[str]) -> str:
    icon = f'<svg class="vi" viewBox="0 0 22 22" aria-hidden="true">{ICONS[kind]}</svg>'
    first, *rest = (svg.escape(sentence) for sentence in words)
    more = f"<p>{' '.join(rest)}</p>" if rest else ""
    return f'<div class="vi-verdict-{kind}"><small>{icon}{HEADS[kind]}</small><b>{first}</b>{more}</div>'
