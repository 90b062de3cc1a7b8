"""Widgets of viser: written only if they differ: nothing is sent when nothing changes."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial

from viser import GuiButtonHandle, IconName

from viewimit.drawing.svg import joint_symbol

from ..model.queue import Command
from ..model.state import PageState
from ..viser_private import push_input, push_property
from .panel import Layout


def put(handle, value) -> None:
    """Write a value only if it differs: nothing is sent when nothing changes. A slider's own rounding is no change."""
    shown = handle.value
    if not _is_number(shown):
        if shown != value:
            handle.value = value
    elif abs(shown - value) > 1e-9:
        push_input(handle, type(shown)(value))


def put_most(slider, value: float) -> None:
    """The largest value that a slider has."""
    if slider.max != value:
        push_property(slider, "max", value)


def put_html(handle, content: str) -> None:
    if handle.content != content:
        push_property(handle, "content", content)


def put_label(button: GuiButtonHandle, label: str, icon: IconName) -> None:
    """What a button does now."""
    if button.label != label:
        button.label, button.icon = label, icon


def put_visible(handle, visible: bool) -> None:
    if handle.visible != visible:
        handle.visible = visible


class JointSliders:
    """One slider for each joint that moves, built anew with every world. inside: where they stand; name: of each, {}
    its joint; parse(k, value): what a person's value of joint k becomes, counted among those that move; degrees."""

    def __init__(
        self,
        layout: Layout,
        inside: AbstractContextManager,
        name: str,
        parse: Callable[[int, object], Command],
        hint: str = "degrees",
    ):
        self._layout, self._inside, self._name, self._parse, self._hint = layout, inside, name, parse, hint
        self._sliders: list = []
        self._generation = -1

    def show(self, state: PageState, angles_deg: Sequence[float]) -> None:
        """angles_deg: (m,)"""
        if state.generation != self._generation:
            self._build(state, angles_deg)
        for slider, angle in zip(self._sliders, angles_deg):
            put(slider, round(angle, 1))

    def _build(self, state: PageState, angles_deg: Sequence[float]) -> None:
        for slider in self._sliders:
            slider.remove()
        scene, self._generation, self._sliders = state.session.scene, state.generation, []
        with self._inside:
            for k, (joint, (low, high)) in enumerate(zip(scene.moving_joints, scene.range_deg)):
                name = self._name.format(joint_symbol(joint))
                slider = self._layout.gui.add_slider(name, low, high, 0.5, angles_deg[k], hint=self._hint)
                self._layout.queue.on_value(slider, partial(self._parse, k))
                self._sliders.append(slider)


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
