"""What `artrec studio` does behind its pages: frames, marks, learning, files; without a browser."""
