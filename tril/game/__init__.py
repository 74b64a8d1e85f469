"""The emulator, the state read from it, and the agents' view of it."""
