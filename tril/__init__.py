"""Tril's domain: the game, recordings, rankings, what is stored; no web and no torch."""

__version__ = "0.2.0"
