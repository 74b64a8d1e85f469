"""Files on disk and elsewhere: the artifact store of runs and the bounded cache."""
