"""What travels between a page and its game: codec, messages, connection."""
