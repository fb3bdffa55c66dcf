"""What is sought and what is found: objects, their joints, the surface they show, detections."""
