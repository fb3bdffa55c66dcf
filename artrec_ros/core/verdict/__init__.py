"""Which hypotheses are objects: claims, ownership of pixels, probability, reasons; what is told of them."""
