"""The subcommands of tril, one module each."""
