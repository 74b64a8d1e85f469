"""Supervision of child processes."""
