"""Environments of Gymnasium as games, without a module each."""
