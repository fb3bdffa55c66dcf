"""What every room uses: errors, the clock, configuration, the compiler."""
