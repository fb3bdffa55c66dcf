"""Names that stay from frame to frame."""
