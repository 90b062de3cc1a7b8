"""Widgets of viser: written only if they differ: nothing is sent when nothing changes."""

from viser import GuiButtonHandle, IconName

from ..viser_private import push_html


def put(handle, value) -> None:
    """Write a value only if it differs: nothing is sent when nothing changes. A slider's own rounding is no change."""
    differs = abs(handle.value - value) > 1e-9 if _is_number(handle.value) else handle.value != value
    if differs:
        handle.value = value


def put_html(handle, content: str) -> None:
    if handle.content != content:
        push_html(handle, content)


def put_label(button: GuiButtonHandle, label: str, icon: IconName) -> None:
    """What a button does now."""
    if button.label != label:
        button.label, button.icon = label, icon


def put_visible(handle, visible: bool) -> None:
    if handle.visible != visible:
        handle.visible = visible


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def told(address: str, media: str) -> str:
    """A picture of nothing: the browser asks for address/1 where this media query holds, for address/0 where it does
    not, and again whenever that changes."""
    return f'<picture hidden=""><source media="{media}" srcset="{address}/1"/><img src="{address}/0" alt=""/></picture>'
