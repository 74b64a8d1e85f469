"""Import and export: recordings, whole behaviours, backups."""
