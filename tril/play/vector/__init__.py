"""Vectors of games, stepped together by processes over shared memory."""
