"""The documentation site: `docs/` and the docstrings of all public names, as pages in a browser.

    python -m tools.documentation            # build/docs/html; `make docs` runs this

===============  =================================================================
public_names     what is public: everything that `__all__` leads to
api_pages        a page for each public module
command_pages    a page with the help of every command
page_figures     pictures drawn by the examples of a page, beside their code
repository_links links that lead to a page on a code host lead to one here, too
staging          all pages in one folder, as Sphinx takes them
accessible_pages what the theme leaves undone for keyboards and screen readers
built_pages      no dead link, no anchor amiss, no public name left out
references       names in docstrings and signatures lead to their entries
mathematics      formulas as MathML, which needs no script and no network
===============  =================================================================

The pages stay plain Markdown that can be read on a code host: nothing in them is Sphinx's own.
"""
