"""From pictures and tracks to image points: frames merged, latency found, markers detected. No robot and no scene."""
