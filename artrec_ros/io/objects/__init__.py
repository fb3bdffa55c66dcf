"""Object files, and what they are made from: outlines, drawings, photos, URDFs."""
