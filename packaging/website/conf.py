"""Sphinx's settings for the site; packaging/build_site.py stages its pages and runs it."""

import re
from importlib.metadata import version as installed_version

from numpy.typing import ArrayLike
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

project = "Lappet"
author = "The Lappet authors"
project_copyright = "The Lappet authors, GPL-3.0-or-later"
version = release = installed_version("lappet")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton", "website.kept_lookups"]
root_doc = "README"
default_role = "py:obj"  # docstrings put code in single backticks; what has a description becomes a link
highlight_language = "none"
smartquotes_action = "D"  # dashes only

myst_heading_anchors = 4  # the anchors of GitHub's Markdown
myst_enable_extensions = ["attrs_inline"]

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_use_type_comments = False  # there are none, and looking for them takes 7 % of the time
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = False
napoleon_attr_annotations = False

# Nothing that the site shows comes from another host: the theme's fonts are the system's.
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["wide.css"]
html_title = f"Lappet {release}"
html_copy_source = False
html_show_sphinx = False

# numpy's aliases come here spelled out.
_ARRAY = re.compile(r"~numpy\.ndarray\[~typing\.Any, ~numpy\.dtype\[(?:~\w+\.)?(\w+)\]\]")
_ARRAY_LIKE = stringify_annotation(ArrayLike, "smart")


def shorten_types(
    app: Sphinx, what: str, name: str, value: object, options: object, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Write a signature's types with the short names that the sources use."""

    def short(text: str | None) -> str | None:
        return text and _ARRAY.sub(r"NDArray[\1]", text.replace(_ARRAY_LIKE, "ArrayLike"))

    return short(signature), short(returns)


def setup(app: Sphinx) -> None:
    """Connect what shortens signatures."""
    app.connect("autodoc-process-signature", shorten_types)
