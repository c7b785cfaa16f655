# SPDX-License-Identifier: LGPL-2.1-or-later
"""What mkdocs.yml adds to mkdocs: the same pages, read in the repository, link to files outside docs/.

Such files become part of the site under their path in the repository, and links follow.
"""

import posixpath
import re
from pathlib import Path

from mkdocs.structure.files import File

LINK = re.compile(r"(\]\()([^)#\s]+)(#[^)\s]*)?\)")
IMAGE = re.compile(r"^(!\[[^]]*\]\(([^)]*)\))$", re.MULTILINE)
LIST_ITEM = re.compile(r"(\*|-|\d+\.) ")
PAGES = ["README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"]


def in_repository(page):
    return page if page in PAGES else f"docs/{page}"


def in_site(path):
    return path[len("docs/") :] if path.startswith("docs/") else path


def target(page, link):
    """The path in the repository of a link on a page; nothing, if it leads elsewhere."""
    if re.match(r"[a-z]+:", link):
        return None
    return posixpath.normpath(posixpath.join(posixpath.dirname(in_repository(page)), link))


def on_files(files, config):
    root = Path(config["config_file_path"]).parent
    outside = set(PAGES)
    for page in [*PAGES, *(file.src_path for file in files.documentation_pages())]:
        for match in LINK.finditer((root / in_repository(page)).read_text()):
            path = target(page, match[2])
            if path and path == in_site(path):
                outside.add(path)
    for path in sorted(outside):
        files.append(File(path, str(root), config["site_dir"], config["use_directory_urls"]))
    files.remove(files.get_file_from_path("site.py"))
    return files


def with_blank_lines(markdown):
    """Markdown of GitHub begins a list or a table right below a paragraph; that of Python needs a blank line."""
    lines, inside = [], False
    for line in markdown.split("\n"):
        before = lines[-1] if lines else ""
        if line.lstrip().startswith("```"):
            inside = not inside
        if not inside and before.strip() and not before[0].isspace():
            begins_list = LIST_ITEM.match(line) and not LIST_ITEM.match(before)
            begins_table = line.startswith("|") and not before.startswith("|")
            if begins_list or begins_table:
                lines.append("")
        lines.append(line)
    return "\n".join(lines)


def on_page_markdown(markdown, page, **_):
    here = page.file.src_path

    def follow(match):
        path = target(here, match[2])
        link = match[2] if path is None else posixpath.relpath(in_site(path), posixpath.dirname(here) or ".")
        return f"{match[1]}{link}{match[3] or ''})"

    # Each image is a link to itself: a phone shows it small.
    return with_blank_lines(IMAGE.sub(r"[\1](\2)", LINK.sub(follow, markdown)))
