"""What a URDF says: its tree of joints, the chain of them that is the arm, the shapes of its links, and their files. No
scene and no camera."""
