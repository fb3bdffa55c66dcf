"""Offline: constraints, classes, colours and poses learned from examples (paper, step 7)."""
