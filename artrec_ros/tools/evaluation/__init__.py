"""What `artrec evaluate` is made of: runs and truth, figures with their intervals, tables and the report page."""
