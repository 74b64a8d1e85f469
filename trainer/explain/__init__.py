"""Attention maps of the reward model."""
