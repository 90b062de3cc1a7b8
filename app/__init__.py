"""The page. Its rooms are server, panels, scene, control, jobs and sessions; the library knows none of it."""
