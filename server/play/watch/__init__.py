"""Watched games: a policy plays, a person looks on and may take over."""
