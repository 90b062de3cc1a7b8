"""The four images: planes, arms, marks, the construction of a point, rectified images, tracked points."""
