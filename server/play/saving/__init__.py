"""How games reach the database: commits, their schedule, checks by replay."""
