"""The page. Its rooms are server, panels, scene, control, jobs, sessions, lessons, classroom and static; the library
knows none of it."""
