"""What a session has of its learner: limits, a way to move and a way to look, in a simulated scene or of one's own."""

from .in_scene import InScene, SceneOpener
from .interface import Arm, Eyes
from .own import OwnOpener
from .protocol import Beginning, Embodiment, Looks, Opener

__all__ = ["Arm", "Beginning", "Embodiment", "Eyes", "InScene", "Looks", "Opener", "OwnOpener", "SceneOpener"]
