"""A finished run as one page that plays its games without a server."""
