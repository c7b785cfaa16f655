#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Checks a built site: every link leads to a file that is there and, where it names one, to a place in it; nothing
is loaded from another site; every page is in the navigation.

Usage: site-links.py FOLDER
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.loads, self.ids = [], [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.ids.update(value for name, value in attributes if name in ("id", "name"))
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        elif tag == "link" and values.get("rel") not in ("canonical", "prev", "next"):
            self.loads.append(values.get("href", ""))
        elif "src" in values:
            self.loads.append(values["src"])


def main(folder):
    root = Path(folder).resolve()
    pages = {path: Page(path.read_text()) for path in root.rglob("*.html") if path.name != "404.html"}
    wrong, count = [], 0
    for path, page in pages.items():
        name = path.relative_to(root)
        wrong += [f"{name} loads {link}" for link in page.loads if re.match("([a-z]+:)?//", link)]
        for link in page.links + page.loads:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            count += 1
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target = target / "index.html"
            if not target.is_file():
                wrong.append(f"{name}: {link} leads nowhere")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].ids:
                wrong.append(f"{name}: {link} leads to a heading that is not there")
    for style in root.rglob("*.css"):
        wrong += [f"{style.name} loads {link}" for link in re.findall(r"url\([\"']?(https?:[^)]*)", style.read_text())]
    reached = {(root / unquote(urlsplit(link).path)).resolve() for link in pages[root / "index.html"].links}
    wrong += [f"{path.relative_to(root)} is not in the navigation" for path in pages if path not in reached]
    print(*wrong, f"{count} links on {len(pages)} pages checked, {len(wrong)} wrong", sep="\n")
    return 1 if wrong or not pages else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
