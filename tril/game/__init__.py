"""The emulator and all that is read off it."""
