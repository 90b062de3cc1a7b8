"""Types of arrays that all parts share."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
