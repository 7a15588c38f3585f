"""Build the site of the documents and the API reference: `build_site.py [--output DIR] [--no-downloads]`.

Sphinx builds it from the repository's Markdown and the docstrings of `lappet`; every warning is an error. Without
`--output` it lies in build/site. It needs no server and no other host: open DIR/index.html.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as sphinx_build

from flap_downloads import write_downloads
from gallery_blends import write_gallery_blends
from website.api_pages import write_api_pages
from website.pages import FRONT_PAGE, GALLERY, stage

ROOT = Path(__file__).resolve().parent.parent


def build_site(output: Path, downloads: bool = False) -> int:
    """Build the site.

    Parameters
    ----------
    output
        The site's folder. Beside it, in `<output>.work`, lies what makes the next build quick.
    downloads
        Whether the pages of flaps offer their operations, and the gallery its projects, as files, which are made here.

    Returns
    -------
    int
        Sphinx's exit status: 0, or 1 where there was a warning or an error.
    """
    work = output.with_name(f"{output.name}.work")
    pages = work / "pages"
    files = work / "downloads" if downloads else None
    if files is not None:
        write_downloads(files)
        write_gallery_blends(files / GALLERY)
    stage(ROOT, pages, files)
    write_api_pages(ROOT / "shared" / "lappet", pages)
    options = ["-b", "html", "-q", "-W", "--keep-going", "-j", "auto", "-c", str(ROOT / "packaging" / "website")]
    status = sphinx_build([*options, "-d", str(work / "doctrees"), str(pages), str(output)])
    if status == 0:
        # Browsers and servers open index.html.
        shutil.copyfile(output / Path(FRONT_PAGE).with_suffix(".html"), output / "index.html")
    return status


def main(arguments: list[str]) -> int:
    """Read the arguments and build."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "site", metavar="DIR")
    parser.add_argument(
        "--no-downloads", action="store_true", help="leave out what flaps and the gallery offer as files"
    )
    given = parser.parse_args(arguments)
    output = given.output.resolve()
    status = build_site(output, downloads=not given.no_downloads)
    if status == 0:
        print(f"the site is in {output / 'index.html'}")
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
