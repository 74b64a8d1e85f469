"""The scripted player of Space Invaders."""
