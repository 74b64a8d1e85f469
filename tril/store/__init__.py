"""Everything SQL. One module of queries per thing; callers pass a session and own the commit."""
