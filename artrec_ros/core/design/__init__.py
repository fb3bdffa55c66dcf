"""Offline: what can be told of an object before anything is printed."""
