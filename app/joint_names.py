"""What joints are called on the pages."""

from viewimit.drawing import svg
from viewimit.simulation.robot import robot_names
from viewimit.simulation.scene import Scene, load_robot

JOINT_NAMES = ("Base", "Shoulder", "Upper arm", "Elbow", "Forearm", "Wrist", "Hand")  # of a human arm


def joint_name(scene: Scene, joint: int) -> str:
    """What a joint is called, with its symbol: the shipped robots' are those of a human arm, others have their own."""
    if scene.robot not in robot_names():
        name = load_robot(scene.robot).joints[joint - 1].name
    else:
        name = JOINT_NAMES[joint - 1] if joint <= len(JOINT_NAMES) else "Joint"
    return f"{name} {svg.joint_symbol(joint)}"
