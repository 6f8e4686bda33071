"""How Sphinx makes the site; `tools/documentation` lays the pages out for it."""

from posflock_robotarium import __version__

project = "posflock-robotarium"
author = "The posflock-robotarium developers"
copyright = author
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_copybutton",
    "tools.documentation.mathematics",
    "tools.documentation.references",
]

# Pages are plain Markdown; every heading can be linked to, as on a code host.
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]

# Every reference has to lead somewhere. Bases from other libraries cannot: no network is asked.
nitpicky = True
nitpick_ignore_regex = [("py:class", r"(abc|enum|typing|gymnasium|pettingzoo)\..*")]

# Single backticks in docstrings name what has an entry, and arguments.
default_role = "py:obj"
highlight_language = "none"
add_module_names = False
# The navigation is made for every page: with a line for each name it would take minutes.
toc_object_entries = False
python_maximum_signature_line_length = 80
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
# The entries of a class are autodoc's; its fields are told once, where the class is.
numpydoc_show_class_members = False

copybutton_prompt_text = "$ "
html_math_renderer = "mathml"
html_theme = "furo"
html_title = "posflock-robotarium"
html_show_sphinx = False
html_copy_source = False
# Opened from disk, a page may not read others, of which a summary would be made.
html_show_search_summary = False
html_static_path = ["static"]
html_css_files = ["site.css"]
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
