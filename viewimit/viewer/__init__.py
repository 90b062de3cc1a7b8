"""What a viewer is shown beside the method's own images: furniture and view of the 3-D scene, arms in the images,
landscapes. The truth, which no transfer or servo may import."""
