"""Sphinx's configuration: a site of docs/ and of the docstrings (``make docs``)."""

from __future__ import annotations

from tril import __version__

project = "Tril"
author = "Tril contributors"
copyright = author
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.apidoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["results", "**/modules.rst"]
html_theme = "furo"
html_title = f"Tril {release}"

myst_heading_anchors = 3

apidoc_modules = [
    {"path": f"../{package}", "destination": f"api/{package}", "separate_modules": True}
    for package in ("tril", "trainer")
]
apidoc_module_first = True
apidoc_automodule_options = {"members", "show-inheritance"}
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
napoleon_use_ivar = True
