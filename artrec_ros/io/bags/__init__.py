"""Bags, read and written without ROS: formats, damage, counts, topics."""
