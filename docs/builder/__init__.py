"""Build the site: the pages of docs/ and of the repository's root, and what is generated from the program itself.

`make docs` calls `python -m docs.builder FOLDER`. Nothing here is installed: the packages know nothing of it.

- `pages` lays every page out for the site: links, headings, blocks;
- `program` writes a page for each command and each diagnostic, from what `cortexc` itself says of them;
- `gallery` searches each example, and keeps one case of each as a replay;
- `site` puts them together and hands them to Zensical.
"""
