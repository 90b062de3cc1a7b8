"""What people ask about a run or a scene: landscapes of E, their minima, observability, trajectories. No servo may."""
