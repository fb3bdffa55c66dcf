"""What `artrec inspect` and `artrec model` say of objects and of how files fit together."""
