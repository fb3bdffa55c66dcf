"""Parameter files: names, types and ranges, what they name, what nobody reads."""
