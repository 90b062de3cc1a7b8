"""The four images."""

from viewimit.drawing.image_planes import holds, image_windows
from viewimit.drawing.images import draw_images
from viewimit.simulation.appearance import Silhouettes, places, reach

from ..control.state import PageState
from ..scene import meshes
from .panel import Layout, Panel
from .widgets import put_html


class ImagesPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._wide, self._generation = layout.wide, -1
        with layout.upper_tab("Images"):
            self._images = layout.gui.add_html("")

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._images.content

    def depends_on(self, state: PageState) -> tuple:
        view = state.view
        return state.generation, state.looked, view.chosen, view.whole_frames, *state.pictures.values()

    def show(self, state: PageState) -> None:
        looked, world = state.looked, state.session.world
        if state.generation != self._generation:
            self._generation = state.generation
            loaded = meshes.link_meshes(world.scene.robot)
            self._silhouettes = Silhouettes({link: mesh.vertices for link, mesh in loaded.items()}, world)
            self._held = [state.present.theta, state.present.theta_demo]  # postures that the windows are to show
            self._windows = image_windows(reach(world, self._held), world.scene.head.image)
        if len(looked.theta) > 2 and not holds(self._windows, places(world, looked)):
            self._held += [looked.theta, looked.theta_demo]
            self._windows = image_windows(reach(world, self._held), world.scene.head.image)
        view = state.view
        drawn = draw_images(
            looked,
            self._silhouettes.bodies(looked),
            self._windows,
            view.chosen,
            view.whole_frames,
            wide=self._wide,
            pictures=state.pictures,
        )
        put_html(self._images, drawn)
