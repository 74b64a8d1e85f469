"""The tril command."""
