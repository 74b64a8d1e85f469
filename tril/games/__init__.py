"""The games that can be taught, one package each; nothing else knows what is in a game."""
