"""CPU time of a rendered picture, and how far markers detected in it are from those in PyBullet's picture.

PYTHONPATH=tests python tests/measure_pictures.py [--postures N] [SCENE ...]
"""

import argparse
import time

import numpy as np
from bullet_pictures import BulletStudio

from viewimit.sensing.detection import detect
from viewimit.simulation.rendering import SEARCHED_WIDTH, Studio
from viewimit.simulation.robot import load_markers
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

SCENES = ["panda", "iiwa", "panda-toed", "panda-verged"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(SCENES))
    parser.add_argument("--postures", type=int, default=20, metavar="N", help="of both arms, random (%(default)s)")
    args = parser.parse_args()
    for name in args.scenes or SCENES:
        print(line(name, args.postures), flush=True)


def line(name, count):
    scene = load_scene(name)
    markers = load_markers(scene.robot)
    world = World(scene, body=markers.body)
    studio, bullet = Studio(world, markers), BulletStudio(scene)
    rng, seconds, away, found = np.random.default_rng(0), [], [], []
    cameras = *world.demo_cameras, *world.own_cameras
    for camera in cameras:  # the room is drawn once
        studio.picture(camera, scene.lower, scene.lower)
    for _ in range(count):
        postures = rng.uniform(scene.lower, scene.upper, (2, len(scene.lower)))
        for camera in cameras:
            began = time.process_time()
            pictures = [studio.picture(camera, *postures)]
            seconds.append(time.process_time() - began)
            pictures.append(bullet.picture(camera, *postures))
            seen = [detect(picture, markers.hue_deg, SEARCHED_WIDTH) for picture in pictures]
            both = seen[0].found & seen[1].found
            away.append((seen[0].points - seen[1].points)[both])
            found.append([both.sum(), (seen[0].found & ~both).sum(), (seen[1].found & ~both).sum()])
    rms = np.sqrt((np.concatenate(away) ** 2).mean())
    both, ours, theirs = np.sum(found, 0)
    median, high = 1e3 * np.quantile(seconds, (0.5, 0.95))
    return (
        f"{name:14} {median:5.1f} ms a picture (95 % {high:.1f}); "
        f"{rms:.3f} px rms over {both} markers, found in one of both {ours} and {theirs}"
    )


if __name__ == "__main__":
    main()
