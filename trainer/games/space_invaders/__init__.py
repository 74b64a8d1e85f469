"""Reading Space Invaders off the screen: memory, and what each move leads to."""
