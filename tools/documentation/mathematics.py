"""Formulas as MathML: browsers draw it themselves, without a script and without a network."""

from __future__ import annotations

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata
from sphinx.writers.html5 import HTML5Translator


def setup(app: Sphinx) -> ExtensionMetadata:
    """Offer the renderer ``mathml`` to Sphinx.

    Parameters
    ----------
    app : Sphinx
        The build.
    """
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(_formula(node))
    raise nodes.SkipNode


def _display(writer: HTML5Translator, node: nodes.math_block) -> None:
    formula = _formula(node).replace("<math ", '<math display="block" ', 1)
    writer.body.append(f'<div class="math" tabindex="0">{formula}</div>')
    raise nodes.SkipNode


def _formula(node: nodes.math | nodes.math_block) -> str:
    formula: str = tex2mathml(node.astext().replace("‖", r"\|"))
    # Braces would stretch to the height of the line, and beyond.
    for brace in "{}":
        formula = formula.replace(f"<mo>{brace}</mo>", f'<mo stretchy="false">{brace}</mo>')
    return formula
