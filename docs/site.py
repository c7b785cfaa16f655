# SPDX-License-Identifier: LGPL-2.1-or-later
"""What mkdocs.yml adds to mkdocs: the same pages, read in the repository, link to files outside docs/.

Such files become part of the site under their path in the repository, and links follow. The first page begins with four
tiles, and with a film to be felt if FEELING_WIND_FILM names the folder of one (pipelines/web/site.sh makes it).
"""

import os
import posixpath
import re
from pathlib import Path

from mkdocs.structure.files import File

LINK = re.compile(r"(\]\()([^)#\s]+)(#[^)\s]*)?\)")
IMAGE = re.compile(r"^(!\[[^]]*\]\(([^)]*)\))$", re.MULTILINE)
LIST_ITEM = re.compile(r"(\*|-|\d+\.) ")
FILM = ["feeling-wind.min.js", "film.klv", "film.mp4", "poster.webp", "LICENSE"]
# The track is loaded when the film plays first.
PLAYER = """<figure class="film">
<feeling-wind><video src="film/film.mp4" poster="film/poster.webp" width="640" height="360" preload="none"
controls playsinline loop muted></video></feeling-wind>
<figcaption>Play the film and move the mouse or a finger over the tree. The arrow is the force that a hand would feel.
A gamepad or a telephone vibrates.</figcaption>
</figure>
<script type="module" src="film/feeling-wind.min.js"></script>
"""
TILES = [
    ("quickstart.html", "See it work", "One command shows a tree in the wind, and what a hand feels."),
    ("devices.html", "Choose a device", "A mouse is enough to begin. Gamepads vibrate, joysticks push."),
    ("web.html", "Show it on the web", "A folder of files for any web server, or one element in your page."),
    ("tutorial.html", "Build a pipeline", "Ten steps from a test picture to a force."),
]
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
    if folder := os.environ.get("FEELING_WIND_FILM"):
        # In the site they are below film/, as below a folder of that name beside them.
        for name in FILM:
            film = File(name, folder, posixpath.join(config["site_dir"], "film"), config["use_directory_urls"])
            film.src_uri = film.dest_uri = film.url = f"film/{name}"
            files.append(film)
    return files


def tiles():
    rows = (f'<a href="{link}"><strong>{name}</strong><span>{text}</span></a>' for link, name, text in TILES)
    return f'<nav class="tiles" aria-label="Begin here">{"".join(rows)}</nav>'


def first_page(markdown):
    """The film and the tiles stand below the first paragraph."""
    film = PLAYER if os.environ.get("FEELING_WIND_FILM") else ""
    heading, first, rest = markdown.split("\n\n", 2)
    return f"{heading}\n\n{first}\n\n{film}\n{tiles()}\n\n{rest}"


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
    text = with_blank_lines(IMAGE.sub(r"[\1](\2)", LINK.sub(follow, markdown)))
    return first_page(text) if here == "README.md" else text


def on_page_content(html, **_):
    # Who reads the first lines does not load the pictures of the last. A corner of a table is no header.
    return html.replace("<img ", '<img loading="lazy" ').replace("<th></th>", "<td></td>")


def usable_by_keys(html):
    """The search of the theme as of Debian 12 has no name, and its results cannot be scrolled by keys."""
    search = 'data-md-component="search" role="dialog"'
    html = html.replace(search, f'{search} aria-label="Search"')
    return html.replace('"md-search__scrollwrap"', '"md-search__scrollwrap" tabindex="0"')


def on_post_page(output, **_):
    return usable_by_keys(output)


def on_post_template(output, template_name, **_):
    return usable_by_keys(output) if template_name == "404.html" else output
