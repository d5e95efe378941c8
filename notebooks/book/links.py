"""Is the built site whole? Every link inside it has its target, and nothing comes from elsewhere."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

__all__ = ["faults"]

LOADED = {"script": "src", "img": "src", "iframe": "src", "link": "href", "source": "src", "video": "src"}
FETCHED_BY_STYLE = re.compile(r"(?:@import\s+|url\()\s*[\"']?(https?:)?//", re.IGNORECASE)
WIDGET_PAGE = "views"  # pages that the package writes and tests itself


class _Page(HTMLParser):
    """Anchors of a page, what it links to and what it loads."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[key] for key in ("id", "name") if key in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in LOADED and LOADED[tag] in given:
            if tag != "link" or given.get("rel") not in ("canonical", "next", "prev", "search", "index"):
                self.loaded.append(given[LOADED[tag]])


def faults(site: Path) -> list[str]:
    """Sentences, one a fault; an empty list if all is well."""
    pages: dict[Path, _Page] = {}
    found = []
    for path in sorted(site.rglob("*.html")):
        page = _Page()
        page.feed(path.read_text(encoding="utf-8"))
        pages[path.resolve()] = page
    for path, page in pages.items():
        here = path.relative_to(site.resolve())
        for address in page.loaded:
            if urlsplit(address).scheme in ("http", "https") or address.startswith("//"):
                found.append(f"{here} loads {address} from elsewhere")
        for address in [*page.links, *page.loaded]:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{here} links to {address}, which isn't there")
            elif parts.fragment and target in pages and WIDGET_PAGE not in here.parts:
                if unquote(parts.fragment) not in pages[target].anchors and "slides" not in target.parts:
                    found.append(f"{here} links to {address}, where no such place is")
    for path in sorted(site.rglob("*.css")):
        if FETCHED_BY_STYLE.search(path.read_text(encoding="utf-8")):
            found.append(f"{path.relative_to(site)} fetches something from elsewhere")
    return found
