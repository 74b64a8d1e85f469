"""Figures about finished games and runs: summaries, extrapolation, the reward alarm."""
