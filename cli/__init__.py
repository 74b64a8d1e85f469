"""The ``tril`` command: composes and supervises the other packages."""
