"""What viser's browser makes of scene messages (SceneTreeState.ts, MessageHandler.tsx): a node's pose, as seen."""

from dataclasses import dataclass

POSED = {"SetOrientationMessage": "wxyz", "SetPositionMessage": "position", "SetSceneNodeVisibilityMessage": "visible"}


@dataclass
class Node:
    """Of one owner: the server, "", or a client."""

    wxyz: tuple = (1, 0, 0, 0)
    position: tuple = (0, 0, 0)
    visible: bool = True


class ViewedScene:
    """A node that is added where its owner has one of that name keeps pose and visibility; a client's own shadows the
    server's."""

    def __init__(self):
        self._nodes: dict[str, dict[str, Node]] = {}  # by name, then owner

    def take(self, message: dict) -> None:
        kind, name, owner = message["type"], message.get("name", ""), message.get("owner", "")
        if kind == "RemoveSceneNodeMessage":
            for each in [each for each in self._nodes if f"{each}/".startswith(f"{name}/")]:
                self._nodes[each].pop(owner, None)
        elif kind in POSED and owner in self._nodes.get(name, {}):
            setattr(self._nodes[name][owner], POSED[kind], message[POSED[kind]])
        elif "props" in message and name.startswith("/"):
            self._nodes.setdefault(name, {}).setdefault(owner, Node())

    @property
    def nodes(self) -> dict[str, Node]:
        """By name, those that are seen: hidden ones and what hangs on them are not."""
        effective = {name: owners.get(max(owners)) for name, owners in self._nodes.items() if owners}
        parents = lambda name: [name[:at] for at in range(1, len(name)) if name[at] == "/"]
        hidden = {name for name, node in effective.items() if not node.visible}
        return {name: node for name, node in effective.items() if hidden.isdisjoint([*parents(name), name])}
