"""Learning: the worker, the reward model, the policies and their evaluation."""
