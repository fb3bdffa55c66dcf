"""What is known of the objects in each frame: from truth.jsonl, bags, COCO files."""
