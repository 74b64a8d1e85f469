"""The web around the API: middleware, security, error answers, the page's files."""
