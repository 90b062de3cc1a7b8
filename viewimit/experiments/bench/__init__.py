"""Benchmarks and studies behind the published figures, each reproducible from a seed.

A new benchmark is a file with a `Benchmark`, and a line here. They judge nothing by the paper.
"""

from .benchmark import Benchmark
from .calibration import CalibrationBenchmark
from .compare import CompareBenchmark
from .misfits import MisfitsBenchmark
from .robustness import PicturesBenchmark, RobustnessBenchmark
from .scenes import RobotsBenchmark, ScenesBenchmark
from .speed import SpeedBenchmark
from .success import SuccessBenchmark
from .tracking import TrackingBenchmark
from .tracks import TracksBenchmark
from .unmatched import UnmatchedBenchmark

BENCHMARKS: dict[str, type[Benchmark]] = {
    "speed": SpeedBenchmark,
    "success": SuccessBenchmark,
    "robustness": RobustnessBenchmark,
    "tracking": TrackingBenchmark,
    "scenes": ScenesBenchmark,
    "calibration": CalibrationBenchmark,
    "compare": CompareBenchmark,
    "pictures": PicturesBenchmark,
    "robots": RobotsBenchmark,
    "tracks": TracksBenchmark,
    "unmatched": UnmatchedBenchmark,
    "misfits": MisfitsBenchmark,
}

__all__ = ["BENCHMARKS", "Benchmark"]
