"""Breakout: what is known of it beside what every Atari game tells."""

from tril.games.breakout.game import BREAKOUT

__all__ = ["BREAKOUT"]
