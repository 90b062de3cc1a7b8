"""From pictures and tracks to image points: detection, averaging, latency and files of trackers. No robot, no scene."""
