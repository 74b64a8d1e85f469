"""Faults against a running Tril: who is hurt how, what clients were told, and what has to hold."""
