"""What games cost and allow, game by game."""
