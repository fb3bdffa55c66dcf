"""Whole objects in space: guesses, votes of the labels, fits to the contours."""
