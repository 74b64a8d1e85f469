"""Policies: the imitator by PPO on the learned reward, and the clone by behaviour cloning."""
