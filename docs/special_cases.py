"""Run the trust region without one of its special cases: python docs/special_cases.py [NAME ...]

For each name it prints how random runs end with the special case and without it. Without a name it lists all.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from viewimit import Session, Settings
from viewimit.servo import trust_region
from viewimit.servo.trust_region import convergence, localisation, options, rules, state, subproblem
from viewimit.servo.trust_region import algorithm as phases

RUNS, MOST_MOTIONS, CLOSE_DEG = 24, 80, 1.0
