"""Benchmarks of learning."""
