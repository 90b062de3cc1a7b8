"""The loop of imitation: settings, session, snapshots, and the robot that it drives."""
