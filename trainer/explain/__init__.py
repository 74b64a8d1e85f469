"""Attention maps of reward models and policies: by occlusion, and quickly by gradient."""
