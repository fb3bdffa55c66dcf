"""Which hypotheses are objects: ownership of pixels, probability, reasons; what is told."""
