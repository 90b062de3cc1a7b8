"""What runs in the process that finds a basin: sessions from many starts, and their drawing. Nothing of viser is here.

It sends what an experiment's process does, without claims and files.
"""

from multiprocessing.connection import Connection

from .experiment_child import Progress, answer


def work(connection: Connection, folder: str) -> None:
    """Carry out the one request that comes through the connection, for its settings."""

    def find(name: str, settings, options: dict) -> None:
        from viewimit.analysis.convergence import find_basin
        from viewimit.simulation.scene import load_scene

        from ..drawing.landscapes import draw_basin

        scene = load_scene(settings.scene, settings.robot, settings.joints, body_points=settings.body_points)
        progress = Progress(connection.send, lambda found: draw_basin(scene, found))
        connection.send(("found", draw_basin(scene, find_basin(settings, progress.tell)), ()))
        connection.send(("files", b""))

    answer(connection, find)
