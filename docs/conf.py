"""How the documentation is built: see `make docs`."""

from __future__ import annotations

import sys
from pathlib import Path

import pcsmooth

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "pcsmooth"
author = "The pcsmooth developers"
copyright = "the pcsmooth developers, GPL-3.0-or-later"
version = release = pcsmooth.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_click",
    "command_pages",
    "mathml",
    "sphinx_gallery.gen_gallery",
]
root_doc = "index"
exclude_patterns = ["gallery", "tables", "auto_gallery/*.py*", "auto_gallery/*.ipynb"]
myst_enable_extensions = ["deflist", "dollarmath", "colon_fence"]
myst_heading_anchors = 3
default_role = "py:obj"

autosummary_generate = True
autodoc_typehints = "none"  # docstrings say types, and shapes with them
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "filename_pattern": "/plot_",
    "ignore_pattern": r"(^|/)(?!plot_)[^/]*\.py$",
    "within_subsection_order": "FileNameSortKey",
    "capture_repr": (),
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1000,
    "abort_on_example_error": True,
    "copyfile_regex": r"$^",
}

html_theme = "pydata_sphinx_theme"
html_title = "pcsmooth"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "show_prev_next": True,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}

_COMMANDS = {
    "index": "denoise point clouds, and estimate their normals and curvatures",
    "denoise": "take the noise out of clouds",
    "curvature": "add normals and curvatures to clouds",
    "info": "say what is in clouds and what suits them",
    "convert": "write clouds in another format",
    "plot": "show two clouds side by side",
    "presets": "list the convex bodies that can stand for the ball",
    "warmup": "compile ahead what a first run would compile",
    "experiments": "do the experiments of the thesis again",
}
man_pages = [
    (
        f"commands/{name}",
        "pcsmooth" if name == "index" else f"pcsmooth-{name}",
        description,
        author,
        1,
    )
    for name, description in _COMMANDS.items()
]
