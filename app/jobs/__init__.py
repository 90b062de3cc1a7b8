"""Heavy work beside the page: landscapes in a thread, experiments and camera images in processes of their own. What is
asked of them, and when, is in control/."""
