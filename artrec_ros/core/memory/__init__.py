"""What one frame tells the next: objects that were there, and blobs that were searched in vain."""
