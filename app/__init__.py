"""The page. Its rooms are server, panels, scene, control, jobs, sessions, classroom, lab and static; the library
knows none of it."""
