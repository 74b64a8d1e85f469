"""Benchmarks of playing."""
