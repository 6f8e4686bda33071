"""What is made of the pages for the site: links, navigation, pictures; and faults that are seen."""

import pytest

from tools.documentation.built_pages import faults_of
from tools.documentation.page_figures import with_figures
from tools.documentation.public_names import PublicName, PublicSurface
from tools.documentation.repository_links import RepositoryLinks
from tools.documentation.staging import ROOT, with_navigation

DRAWING = """\
Text.

```python
from posflock_robotarium.figures.style import new_figure
figure = new_figure(1, 1)
```

```python
figure.savefig("drawn.svg"){told}
```
"""


def test_links_between_pages_and_to_the_code_lead_to_pages():
    links = RepositoryLinks(ROOT)
    text = "[a](report.md#x) [b](../../SECURITY.md) [c](../../tools/mutants.py) [d](https://e.f)\n"
    made = links.rewritten(f"{text}```text\n[e](nowhere.md)\n```\n", "docs/how-to/verify.md")
    assert "[a](report.md#x) [b](../project/SECURITY.md)" in made
    assert "[c](../source/tools/mutants.py.md) [d](https://e.f)" in made
    assert "[e](nowhere.md)" in made
    (page,) = links.source_pages().values()
    assert (ROOT / "tools/mutants.py").read_text() in page


def test_a_link_to_a_folder_leads_to_a_list_of_its_files():
    links = RepositoryLinks(ROOT)
    links.rewritten(
        "[claims](../../posflock_robotarium/paper/claims)", "docs/explanations/paper.md"
    )
    pages = links.source_pages()
    folder = pages["source/posflock_robotarium/paper/claims.md"]
    assert "- [alignment.py](claims/alignment.py.md)" in folder
    assert "source/posflock_robotarium/paper/claims/alignment.py.md" in pages


def test_a_link_that_leads_nowhere_is_refused():
    with pytest.raises(FileNotFoundError, match=r"nowhere\.py"):
        RepositoryLinks(ROOT).rewritten("[a](../nowhere.py)", "docs/index.md")


def test_the_links_of_the_index_are_the_navigation():
    made = with_navigation("# Site\n\n## Tutorials\n\n- [One](tutorials/one.md): first.\n")
    assert ":caption: Tutorials\n\nOne <tutorials/one>\n" in made


def test_a_picture_that_an_example_draws_stands_below_it(tmp_path):
    made = with_figures(DRAWING.format(told="  # A square"), tmp_path / "page.md")
    assert made.endswith("```\n\n![A square](drawn.svg)\n")
    assert (tmp_path / "drawn.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_a_picture_without_words_is_refused(tmp_path):
    with pytest.raises(ValueError, match="what the picture shows"):
        with_figures(DRAWING.format(told=""), tmp_path / "page.md")


@pytest.mark.parametrize(
    ("page", "said"),
    [
        ('<a href="gone.html">x</a>', "gone.html leads nowhere"),
        ('<a href="#gone">x</a>', "#gone names an anchor that is not there"),
        ('<script src="https://cdn.example/x.js"></script>', "without a network"),
        ("", "p.m.f is public and has no entry"),
    ],
)
def test_faults_of_a_built_site_are_seen(tmp_path, page, said):
    entry = "" if said.startswith("p.m") else '<dt id="p.m.f"></dt>'
    (tmp_path / "reference/api").mkdir(parents=True)
    (tmp_path / "reference/api/p.m.html").write_text(entry)
    (tmp_path / "index.html").write_text(f'<a href="reference/api/p.m.html#">x</a>{page}')
    surface = PublicSurface({}, (PublicName("p.m", "f", test_a_picture_without_words_is_refused),))
    (fault,) = faults_of(tmp_path, surface)
    assert said in fault


def test_a_sound_site_has_no_faults(tmp_path):
    (tmp_path / "index.html").write_text('<a id="a" href="#a">x</a><a href="https://e.f">y</a>')
    assert faults_of(tmp_path, PublicSurface({}, ())) == []
