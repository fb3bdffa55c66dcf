"""Similarities of the image plane, rigid motions of space, the camera."""
