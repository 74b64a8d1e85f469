"""The reward model: its network, how it is learned from ranked trajectories, its check."""
