"""What examples taught, and the examples: constraints, colours, annotations, regions."""
