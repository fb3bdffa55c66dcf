"""What a replay writes: detections, its journal, a bag of results."""
