"""Import and export: recordings, behaviours, runs, backups."""
