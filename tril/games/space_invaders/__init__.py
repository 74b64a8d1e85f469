"""Space Invaders, the published case."""
