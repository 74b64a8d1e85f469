"""Reports of runs and the results page, the ledger, tables and figures."""
