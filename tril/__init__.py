"""Tril's domain: the game, recordings, rankings, what is stored; no web and no torch."""

import os

__version__ = "0.2.0"

# The queue's library would else take the name and the database of another application, if this
# machine runs one in its maker's cloud. It has to be set before that is loaded.
os.environ["DBOS__CLOUD"] = "false"
