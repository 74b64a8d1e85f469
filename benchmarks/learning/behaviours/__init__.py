"""26 behaviours in nine games, players that show them well and badly, and what Tril learns."""
