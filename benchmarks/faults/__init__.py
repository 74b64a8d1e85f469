"""A campaign of faults against a running Tril."""
