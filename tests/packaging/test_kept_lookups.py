"""What the site keeps from page to page changes no page."""

from __future__ import annotations

from pathlib import Path

import pytest
from sphinx.cmd.build import main as sphinx_build
from sphinx.domains.python import PythonDomain
from sphinx.environment.adapters import toctree

PAGES = {
    "README.rst": """
Front
=====

A part
------

.. toctree::

   usage
   api/index

Another part
------------

`near`, `far` and `far`; :py:func:`both`.
""",
    "usage.rst": "Usage\n=====\n\nFirst\n-----\n\nThen\n----\n\n:py:func:`near` and :py:func:`.twice`\n",
    "api/index.rst": "API\n===\n\n.. toctree::\n   :hidden:\n\n   one\n   two\n",
    "api/one.rst": """
one
===

.. py:module:: one

.. py:function:: near(value: far) -> twice

.. py:function:: both()

.. py:class:: twice
""",
    "api/two.rst": """
two
===

.. py:module:: two

.. py:class:: far

   .. py:method:: near(other: twice, more: far) -> far

.. py:function:: both(value: far, other: far)
""",
}


def built(folder: Path, *extensions: str) -> dict[str, bytes]:
    """The pages of a small site with the theme of the real one."""
    for name, text in PAGES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (folder / "conf.py").write_text(
        f"extensions = {list(extensions)}\nroot_doc = 'README'\nhtml_theme = 'furo'\ndefault_role = 'py:obj'\n"
    )
    assert sphinx_build(["-b", "html", "-q", str(folder), str(folder / "html")]) == 0
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for kind in ("*.html", "searchindex.js", "objects.inv")
        for file in (folder / "html").rglob(kind)
    }


def test_pages_are_the_same_and_are_made_with_less(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    copied: list[object] = []
    find, copy = PythonDomain.find_obj, toctree._toctree_copy_seq
    monkeypatch.setattr(PythonDomain, "find_obj", lambda *given: asked.append(str(given)) or find(*given))
    monkeypatch.setattr(
        toctree, "_toctree_copy_seq", lambda *given, **more: copied.append(given) or copy(*given, **more)
    )
    plain = built(tmp_path / "plain")
    looked, made = len(asked), len(copied)
    kept = built(tmp_path / "kept", "website.kept_lookups")
    assert kept.keys() == plain.keys()
    assert [name for name in plain if kept[name] != plain[name]] == []
    assert b"two.html#two.far" in kept["html/api/one.html"]
    assert len(asked) - looked < looked
    assert len(copied) - made < made
