"""Behaviours of several games, players that show them well and badly, and what Tril makes of it."""
