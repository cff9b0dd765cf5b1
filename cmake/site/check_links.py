# SPDX-License-Identifier: MIT
"""python3 check_links.py SITE: every link of the pages of a site leads to a file of it, and to a place in that file that
there is; nothing is loaded from elsewhere."""

import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, file):
        super().__init__()
        self.places, self.links, self.loaded = set(), [], []
        self.feed(file.read_text(errors="replace"))

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        for name in ("id", "name"):
            if values.get(name):
                self.places.add(values[name])
        if tag in ("a", "area") and values.get("href"):
            self.links.append(values["href"])
        elif tag in ("img", "script", "iframe") and values.get("src"):
            self.loaded.append(values["src"])
        elif tag == "link" and values.get("href"):
            self.loaded.append(values["href"])


def main(folder):
    site = pathlib.Path(folder).resolve()
    pages = {file: Page(file) for file in sorted(site.rglob("*.html"))}
    faults = set()
    count = 0
    for file, page in pages.items():
        if file.name == "404.html":  # its links begin at the root of a server
            continue
        for link in page.links + page.loaded:
            if link == "#nested-classes":  # doxygen 1.9.4 also writes it where these are private and not shown
                continue
            parts = urllib.parse.urlsplit(link)
            where = file.relative_to(site)
            if parts.scheme in ("data", "javascript", "mailto"):
                continue
            if parts.scheme or parts.netloc:
                if link in page.loaded:
                    faults.add(f"{where}: loads {link}")
                continue
            count += 1
            target = (file.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else file
            if target.is_dir():
                target = target / "index.html"
            if not target.exists():
                faults.add(f"{where}: links to {link}: no such file")
            elif parts.fragment and target in pages and urllib.parse.unquote(parts.fragment) not in pages[target].places:
                faults.add(f"{where}: links to {link}: no such place in the page")
    print(f"{len(pages)} pages, {count} links")
    if not pages or faults:
        sys.exit("\n".join(sorted(faults)) or f"no page under {site}")


if __name__ == "__main__":
    main(sys.argv[1])
