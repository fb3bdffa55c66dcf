"""`artrec replay`: frames recognised by many workers, put together in order."""
