"""The four images: which part of each is shown, what the transfer says about them, how a point is recovered, and how
they look when they are rectified. Pictures that cameras take are only placed here."""
