"""Parts put together to objects, all of a frame at once (paper, step 8)."""
