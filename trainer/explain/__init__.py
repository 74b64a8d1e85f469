"""Attention maps of the reward model: by occlusion, and quickly by gradient."""
