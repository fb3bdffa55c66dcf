"""What one frame tells the next: objects that were there, blobs that were searched in vain."""
