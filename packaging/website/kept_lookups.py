"""What Sphinx would make again for every page of the site: the tree of titles beside it, and where names of Python are.

The tree names the titles of all pages; Sphinx makes it from copies of their whole tables of contents, each name of the
API among them, and throws most of these away.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.domains.python import ObjectEntry, PythonDomain
from sphinx.environment import BuildEnvironment

_BEFORE_THE_THEME = 400  # which asks for the tree at 500


class KeptPythonDomain(PythonDomain):
    """Python's names, each looked up once for all that refers to it: a short name is looked for among all others."""

    def find_obj(
        self,
        env: BuildEnvironment,
        modname: str,
        classname: str,
        name: str,
        type: str | None,
        searchmode: int = 0,
    ) -> list[tuple[str, ObjectEntry]]:
        """Look a name up as Sphinx does.

        Parameters
        ----------
        env, modname, classname, name, type, searchmode
            As Sphinx has them.

        Returns
        -------
        list[tuple[str, ObjectEntry]]
            What bears the name.
        """
        kept: dict[Any, list[tuple[str, ObjectEntry]]] = self.__dict__.setdefault("_kept", {})
        name = name.removesuffix("()")
        if searchmode == 1 and not {f"{modname}.{classname}.{name}", f"{modname}.{name}"} & self.objects.keys():
            modname = classname = ""  # it is not near what refers to it: the same is found from everywhere
        asked = (len(self.objects), modname, classname, name, type, searchmode)
        if asked not in kept:
            kept[asked] = super().find_obj(env, modname, classname, name, type, searchmode)
        return list(kept[asked])


def _titles(toc: nodes.bullet_list) -> nodes.bullet_list:
    """A page's title and the pages below it, of its table of contents."""
    short = toc.copy()
    for item in toc.children:
        if isinstance(item, nodes.list_item):
            kept = item.copy()
            kept += item.children[0].deepcopy()
            below = [tree.copy() for tree in item.findall(addnodes.toctree)]
            if below:
                kept += nodes.bullet_list("", *below)
            short += kept
        else:
            short += item.deepcopy()
    return short


def _offer_titles(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document) -> None:
    """Have the tree beside a page made from titles."""
    whole = context.get("toctree")
    if whole is not None:
        context["toctree"] = _from_titles(app.env, whole)


def _from_titles(env: BuildEnvironment, whole: Callable[..., str]) -> Callable[..., str]:
    def toctree(**options: Any) -> str:
        if not options.get("titles_only"):
            return whole(**options)
        every = env.tocs
        if not hasattr(env, "lappet_titles"):
            env.lappet_titles = {name: _titles(toc) for name, toc in every.items()}
        env.tocs = env.lappet_titles
        try:
            return whole(**options)
        finally:
            env.tocs = every

    return toctree


def setup(app: Sphinx) -> dict[str, bool]:
    """Take the place of what would look things up again.

    Parameters
    ----------
    app
        Sphinx.

    Returns
    -------
    dict[str, bool]
        That pages may be read and written by several processes.
    """
    app.add_domain(KeptPythonDomain, override=True)
    app.connect("html-page-context", _offer_titles, priority=_BEFORE_THE_THEME)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
