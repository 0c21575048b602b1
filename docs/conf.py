"""Settings of the documentation: `make docs` builds it from this folder into `site/`."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_extensions")]

project = "multisrt"
html_title = "multisrt"
language = "en"
smartquotes = False  # what programs say is shown as they say it

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "linked_code",
    "mathml",
    "structures",
]
exclude_patterns = ["_extensions", "figures"]

# Pages: Markdown that a code host shows as well. Their examples are run by the tests.
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "off"
highlight_language = "none"

# The API, from the docstrings.
default_role = "literal"
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_custom_sections = [("Attributes", "params_style")]
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
python_maximum_signature_line_length = 88

html_theme = "pydata_sphinx_theme"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {
    "header_links_before_dropdown": 7,
    "navbar_end": ["theme-switcher"],
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
# Pages without others beside them need no list of them.
html_sidebars = {name: [] for name in ("index", "start", "gallery", "glossary")}
html_show_sourcelink = False
copyright = "the authors of multisrt, MIT licence"

copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True
