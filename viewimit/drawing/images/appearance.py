"""What both arms look like in the four images, and which part of each image is shown: computed for the panels."""

from ...loop.snapshot import Snapshot
from ...simulation.appearance import Bodies, Silhouettes, places, reach
from ...simulation.link_meshes import link_meshes
from ...simulation.world import World
from .planes import Windows, holds, image_windows


class Appearance:
    """Of one world. first: a moment whose postures the windows are to show."""

    def __init__(self, world: World, first: Snapshot):
        meshes = link_meshes(world.scene.robot)
        self._world = world
        self._silhouettes = Silhouettes({link: mesh.vertices for link, mesh in meshes.items()}, world)
        self._held = [first.theta, first.theta_demo]
        self._windows = image_windows(reach(world, self._held), world.scene.head.image)

    def of(self, moment: Snapshot) -> tuple[Bodies, Windows]:
        """With many joints an arm may leave the windows, which then widen."""
        if len(moment.theta) > 2 and not holds(self._windows, places(self._world, moment)):
            self._held += [moment.theta, moment.theta_demo]
            self._windows = image_windows(reach(self._world, self._held), self._world.scene.head.image)
        return self._silhouettes.bodies(moment), self._windows
