"""What is sought and what is found: objects, their joints and surface, detections."""
