"""What all games of the emulated Atari 2600 share."""
