"""What the node says, as plain values: topics, detections, markers."""
