"""Servers and players for the benchmarks of playing: real processes, real WebSockets."""
