"""What was learned of pairs of markers, and checked (paper, step 6)."""
