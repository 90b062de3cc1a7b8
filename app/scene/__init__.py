"""The 3-D scene: arms, fixtures, image plates, rays, view, gizmo. It holds handles of nodes and no simulation."""
