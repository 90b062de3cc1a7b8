"""Where the runs of a study are made: in processes here or on a cluster, and the folder that keeps what is done.
What a run is, they are given."""
