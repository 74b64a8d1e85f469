"""Episodes of a game, however it is played, and the agents' view of them."""
