"""What of a game is read off screens, with answers that its memory gives."""
