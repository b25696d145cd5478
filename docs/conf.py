"""Configuration of the documentation: `sphinx-build -W -b html docs docs/_build/html`."""

import logging
import os
import sys
from pathlib import Path


# The workers of a study share the cores: numerical libraries keep to one thread.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import matplotlib as mpl

import fefinger


HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

# Modules of this folder, which is on the path only now.
import generate  # noqa: E402
import report_pages  # noqa: E402
from pictures import shown_figures  # noqa: E402


mpl.use("agg")
logging.getLogger("skfem").setLevel(logging.WARNING)  # Sphinx prints what is below

project = "fefinger"
author = "The fefinger developers"
copyright = "2026, The fefinger developers"
version = release = fefinger.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "formulas",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "gallery", "generated", "**/GALLERY_HEADER.rst"]
templates_path = ["_templates"]
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"fefinger {version}"
html_static_path = ["_static"]
html_css_files = ["fefinger.css"]
suppress_warnings = ["config.cache"]  # the order of the examples is a function

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120

autosummary_generate = True
autodoc_default_options = {"members": True, "inherited-members": False}
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "filename_pattern": r"plot_",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": (shown_figures, "matplotlib"),
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "abort_on_example_error": True,
    "min_reported_time": 5,
    "notebook_extensions": set(),  # MyST-NB would run them a second time
    "plot_gallery": "True",
}


def setup(app):
    """Write the pages that are made from the code and from the reports."""
    generate.write(HERE)
    app.connect("doctree-read", report_pages.link, priority=0)  # before downloads are collected
    app.connect("build-finished", report_pages.copy)
    app.connect("build-finished", generate.notebook)
