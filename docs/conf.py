"""Sphinx's configuration: the site of docs/ and of the docstrings (``make docs``)."""

from __future__ import annotations

from tril import __version__

project = "Tril"
author = "Tril contributors"
release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.apidoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["**/modules.rst"]
html_theme = "furo"
html_title = f"Tril {release}"
myst_heading_anchors = 3

apidoc_modules = [
    {"path": f"../{package}", "destination": f"api/{package}", "separate_modules": True}
    for package in ("tril", "trainer")
]
apidoc_automodule_options = {"members", "show-inheritance"}
apidoc_module_first = True
autodoc_inherit_docstrings = False
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
napoleon_use_ivar = True

# Many classes have attributes of the same name; Sphinx then links to the first.
suppress_warnings = ["ref.python"]
