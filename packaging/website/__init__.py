"""The site: pages staged from the repository's Markdown, an API reference from docstrings, built by Sphinx."""
