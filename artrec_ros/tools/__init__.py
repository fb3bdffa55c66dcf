"""The subcommands of `artrec`, one file each."""
