"""Markers' outlines on blobs' contours (paper, steps 3 to 5)."""
