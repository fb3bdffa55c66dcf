"""`artrec tune`: parameters searched on one part of the frames, judged on another."""
