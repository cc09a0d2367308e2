"""mdBook preprocessor: links out of docs/ lead from the book to the files of the checkout.

A page of docs/ links to `../../reports/README.md`, relative to its own place in docs/. Its HTML page is in
target/book, one folder deeper, so the link gets one more `../`. It also gets a query without meaning, since
mdBook turns every `.md` at the end of a relative link into `.html`.
"""

import json
import posixpath
import re
import sys


def outside(folder: str, target: str) -> bool:
    """Whether a link from a page in `folder` (relative to docs/) leaves docs/."""
    if "://" in target or target.startswith(("#", "/", "mailto:")):
        return False
    return posixpath.normpath(posixpath.join(folder, target)).startswith("..")


def rewritten(page: str, text: str) -> str:
    """The text of a page with its links out of docs/ corrected."""
    folder = posixpath.dirname(page)

    def link(match: re.Match) -> str:
        target = match[1]
        if not outside(folder, target):
            return match[0]
        path, _, anchor = target.partition("#")
        return f"](../{path}?{'#' + anchor if anchor else ''})"

    return re.sub(r"\]\(([^)\s]+)\)", link, text)


def walk(items: list) -> None:
    """Corrects the chapters and what is below them."""
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter is None:
            continue
        if chapter.get("path"):
            chapter["content"] = rewritten(chapter["path"], chapter["content"])
        walk(chapter["sub_items"])


def main() -> None:
    if sys.argv[1:2] == ["supports"]:
        return
    _, book = json.load(sys.stdin)
    walk(book.get("items", book.get("sections", [])))
    json.dump(book, sys.stdout)


main()
