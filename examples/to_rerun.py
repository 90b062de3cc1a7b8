"""A run as a Rerun recording: points and residuals of all four views, E and the joints, motion by motion.

    pip install rerun-sdk
    python examples/to_rerun.py run.rrd
    rerun run.rrd

`log_session` takes any session: of a scene, of your own robot, or of a recorded run.
"""

import sys

import numpy as np
import rerun as rr

from viewimit import Session, Settings

VIEWS = ("demo_left", "demo_right", "own_left", "own_right")
SEEN, RECOVERED, RESIDUAL = (0, 110, 180), (200, 80, 0), (190, 40, 40)  # RGB


def log_session(recording: rr.RecordingStream, session: Session) -> None:
    """Log all motions of a session, on the timeline "motion"."""
    for now in session.history:
        recording.set_time("motion", sequence=now.motion)
        names = [str(k) for k in np.flatnonzero(now.usable)]
        for view in VIEWS:
            points = getattr(now.views, view)[now.usable]
            recording.log(f"{view}/seen", rr.Points2D(points, colors=SEEN, radii=3, labels=names, show_labels=False))
        if now.transfer is not None:
            for view, recovered in zip(VIEWS[2:], np.split(now.recovered[now.usable], 2, axis=1)):
                away = getattr(now.views, view)[now.usable] - recovered
                recording.log(f"{view}/recovered", rr.Points2D(recovered, colors=RECOVERED, radii=2))
                recording.log(f"{view}/residual", rr.Arrows2D(vectors=away, origins=recovered, colors=RESIDUAL))
            recording.log("E", rr.Scalars(now.E))  # px²
        for joint, angle in enumerate(np.degrees(now.theta)):
            recording.log(f"joints/{joint}", rr.Scalars(angle))  # degrees
        recording.log("status", rr.TextLog(str(now.status)))


def main(path: str, session: Session) -> None:
    recording = rr.RecordingStream("viewimit")
    recording.save(path)
    log_session(recording, session)
    recording.flush()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    session = Session(Settings(demonstrator_deg=(45, -90), start_deg=(25, -45)))
    session.run()
    main(sys.argv[1], session)
    print(f"{session.snapshot.motion} motions in {sys.argv[1]}")
