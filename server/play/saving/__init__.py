"""How games reach the database: ownership, commits and their schedule, verification."""
