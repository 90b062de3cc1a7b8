"""What an arm makes of a command."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Actuator:
    """What an arm makes of a command: (1 + gain_error) of it, in steps of quantum_deg."""

    gain_error: float = 0.0
    quantum_deg: float = 0.0

    def move(self, theta: NDArray, command: NDArray) -> NDArray:
        """From theta by command, (m,) rad each → where it stands."""
        after = theta + (1 + self.gain_error) * command
        if self.quantum_deg:
            quantum = np.radians(self.quantum_deg)
            after = quantum * np.round(after / quantum)
        return after
