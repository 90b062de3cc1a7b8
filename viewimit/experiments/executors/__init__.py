"""Where the runs of a study are made, and the folder that keeps finished ones."""
