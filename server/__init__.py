"""What people talk to: the HTTP API, the play sessions and the page's files."""
