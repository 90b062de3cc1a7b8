"""A page without a browser, and what stands for its surroundings."""

import threading
import time
from dataclasses import replace

from drawn import view_name
from quiet_client import quiet_client
from viewimit.app.commands import COMMANDS
from viewimit.app.jobs.camera_images import CameraLost
from viewimit.app.model.choices import AMOUNTS
from viewimit.app.model.page_model import PageModel
from viewimit.app.model.queue import CommandQueue
from viewimit.app.model.services import Services
from viewimit.app.page.page import Page
from waiting import wait_until

from viewimit.loop.settings import Settings
from viewimit.simulation.robot import load_markers
from viewimit.simulation.world import World

CONTROLS = {  # what a browser's values become: a command, and its arguments before the value
    **{f"joint{k}": ("pose_joint", k) for k in range(7)},
    **{name: ("disturbance", name) for name in AMOUNTS},
    **{name: ("switch", name) for name in ("rays", "residuals", "gizmo", "whole_frames", "rectified", "dark")},
    "joints": ("joints",),
    "seed": ("seed",),
    "points": ("points",),
    "rectify": ("rectify",),
    "camera": ("camera",),
    "transfer": ("transfer",),
    "servo": ("servo",),
    "hand": ("pose_hand",),
    "preset": ("preset",),
    "speed": ("speed",),
    "history": ("moment",),
    "chosen": ("choose_point",),
    "opponent's transfer": ("opponent_transfer",),
    "opponent's servo": ("opponent_servo",),
    "experiment": ("experiment",),
    "motion": ("motion",),
    "moment": ("motion_time",),
    "motion file": ("load_motion",),
}
BUTTONS = {  # commands
    "play": "play",
    "step": "step",
    "undo": "undo",
    "reset": "reset",
    "next point": "next_point",
    "view": "fit_view",
    "help": "help",
    "transfers": "compare",
    "duel": "duel",
    "rehearse": "rehearsal",
    "run": "run",
    "download": "download",
    "record": "record",
    "replay": "replay",
    "save motion": "save_motion",
    "edit points": "edit_points",
    "remove point": "remove",
    "best next": "best",
    "save scene": "scene",
}


def call(name, *values):
    """A command with what a browser sends."""
    return COMMANDS[name](*values)


def link(name, value):
    """A command as a link of the drawings calls it."""
    command = COMMANDS[name]
    assert command.link
    return command(*(value for _ in command.parsers))


class Hands:
    """Does at once to a model what a visitor does with a browser: raises ValueError for what cannot be."""

    def __init__(self, model, queue=None):
        self.model, self.queue = model, queue

    def set(self, name, value):
        call(*CONTROLS[name], value).apply(self.model, 0.0)

    def act(self, name, now=0.0):
        call(BUTTONS[name]).apply(self.model, now)

    def set_view(self, **fields):
        self.model.view = replace(self.model.view, **fields)

    def arrive(self):
        """Carry out what workers have put into the queue."""
        for command in self.queue.take():
            command.apply(self.model, 0.0)


class QuietLandscapes:
    """Takes what is asked of it, and makes nothing."""

    def ask(self, page, kind, make, take, moves=False):
        pass


class QuietExperiments:
    """Takes what is asked of it."""

    def __init__(self):
        self.asked, self.cancelled = [], 0

    def ask(self, page, request, tell):
        self.asked.append(request)
        self.tell = tell

    def cancel(self, page):
        self.cancelled += 1


def quiet_model(settings, experiments=None, send=lambda *file: None, landscapes=None, basins=None):
    """A page's model whose workers make nothing unless they are given, and the queue that they would hand it to."""
    workers = {"landscapes": landscapes or QuietLandscapes(), "experiments": experiments or QuietExperiments()}
    services = Services(lambda robot, arm: None, **workers, **({} if basins is None else {"basins": basins}))
    queue = CommandQueue(COMMANDS)
    return PageModel(settings, services, queue, send), queue


class Camera:
    """Stands for the process: looks at projected markers, as long as its gate is open. asked: by which threads."""

    def __init__(self):
        self.gate, self.asked = threading.Event(), []
        self.loss = None
        self.gate.set()

    def look(self, scene, theta, pair, posture):
        self.asked.append((pair, threading.get_ident()))
        assert self.gate.wait(30)
        if self.loss:
            raise CameraLost(self.loss)
        world = World(scene, body=load_markers(scene.robot).body)
        images = world.demo_images(posture) if pair == "lr" else world.own_images(posture)
        return images, (b"left", b"right"), theta


class Visit:
    """A page without a browser, ticked by hand in a clock of its own."""

    def __init__(self, camera, settings=None):
        self.now = 100.0
        services = Services(lambda robot, arm: None, camera, clock=lambda: self.now)
        self.page = Page(quiet_client(id(self)), services, settings or Settings())
        self.session, self.player, self.duel = (
            getattr(self.page.model, name) for name in ("session", "player", "duel")
        )

    def put(self, name, value):
        self.page.queue.call(*CONTROLS[name], value)

    def act(self, name):
        self.page.queue.call(BUTTONS[name])

    def tick(self, count=1):
        for _ in range(count):
            self.now += 0.05
            self.page.tick(self.now)
            self.page.draw()

    def rest(self, seconds=30.0):
        """Tick until no turn goes on."""
        self.tick()
        wait_until(lambda: not self.page.busy, seconds, lambda pause: (time.sleep(pause), self.tick()))

    def arrive(self):
        self.rest()
        self.tick(40)

    @property
    def said(self):
        return self.page.layout.named["status"].content

    @property
    def images(self):
        return self.page.layout.named["images"].content

    @property
    def photographs(self):
        """Views with a picture, as drawn."""
        planes = self.images.split("<svg ")[1:]
        return sorted(view_name(plane) for plane in planes if "data:image/jpeg" in plane)
