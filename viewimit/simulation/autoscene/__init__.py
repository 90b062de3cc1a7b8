"""A scene for a robot of which only the URDF is known: what moves and how far, what is seen of it, and from where.
What a URDF says is read in urdf/."""
