"""Read URDFs: the tree of joints, the chain that is the arm, and the meshes of its links. No scene, no camera."""
