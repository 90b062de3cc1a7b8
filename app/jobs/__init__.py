"""Heavy work beside the page: landscapes in a thread, experiments and camera images in processes of their own.
app/model decides what they compute, and when."""
