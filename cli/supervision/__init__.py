"""Child processes: started, restarted, stopped."""
