"""Scenes with known truth, rendered from object models: examples to train on and bags to test with."""
