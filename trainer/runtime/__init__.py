"""The worker and inference processes, and the stages a run goes through."""
