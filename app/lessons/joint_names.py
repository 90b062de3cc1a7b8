"""What lessons call the joints that move, in plain words."""

from collections.abc import Sequence

from viewimit.simulation.scene import Scene

NAMES = {2: "shoulder", 4: "elbow", 6: "wrist"}  # of arms of seven joints, numbered from 1


def joint_names(scene: Scene) -> Sequence[str]:
    """Of the scene's moving joints, base to tip."""
    return [NAMES.get(joint, f"joint {joint}") for joint in scene.moving_joints]
