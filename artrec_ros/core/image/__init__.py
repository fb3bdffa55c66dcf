"""From an image to class labels, blobs and their contours (paper, steps 1 and 2)."""
