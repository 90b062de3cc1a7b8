"""The nodes of one page's scene, from world to world."""

from typing import TypeVar

from viser import SceneNodeHandle

Node = TypeVar("Node", bound=SceneNodeHandle)


class Nodes:
    """`begin` a world, `keep` each node as it is added, then `end`, which hides what has not come again.

    Nothing is removed: viser sends every pose of a node that takes another's place under its name. Where one is removed
    and comes again before the browser has heard of it, it sends no pose that is the default, and the old one stays.
    """

    def __init__(self) -> None:
        self._of_before: dict[str, SceneNodeHandle] = {}
        self._of_world: dict[str, SceneNodeHandle] = {}

    def begin(self) -> None:
        self._of_before |= self._of_world
        self._of_world = {}

    def keep(self, node: Node) -> Node:
        self._of_world[node.name] = node
        return node

    def end(self) -> None:
        for name, node in self._of_before.items():
            if name not in self._of_world:
                node.visible = False
