"""What the database holds of trainings: runs, leases, metrics, evaluations, artifacts."""
