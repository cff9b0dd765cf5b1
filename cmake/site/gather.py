# SPDX-License-Identifier: MIT
"""python3 gather.py ROOT PAGES NAVIGATION: copies the Markdown of the repository, in the same folders, to where mkdocs
reads it. The Markdown works on a plain Git host, so it links to sources and folders; mkdocs knows pages only. A link
to a public header goes to its page of the interface, one to another text file to a page that shows it, one to a folder
to its README or to a list of its files. A link that leads nowhere, and a page of docs/ that is not in the
navigation, is an error."""

import os
import pathlib
import re
import shutil
import sys

FENCE = re.compile(r"^ *(```|~~~)")
LINK = re.compile(r"\]\(([^()\s]+)\)")
PICTURES = {".png", ".svg"}
LANGUAGES = {".cpp": "cpp", ".h": "cpp", ".c": "c", ".py": "python", ".sh": "sh", ".cmake": "cmake", ".yml": "yaml"}


class Gatherer:
    def __init__(self, root, pages):
        self.root, self.pages = root, pages
        self.todo = [root / name for name in ("README.md", "DESIGN.md", "CONTRIBUTING.md", "CHANGELOG.md")]
        self.todo += sorted((root / "docs").rglob("*.md"))
        self.done = set()
        self.faults = []

    def run(self):
        while self.todo:
            page = self.todo.pop()
            if page not in self.done:
                self.done.add(page)
                self.gather(page)

    def write(self, place, text):
        out = self.pages / place
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(text)

    def gather(self, page):
        lines, fenced = [], False
        for number, line in enumerate(page.read_text().split("\n"), 1):
            if FENCE.match(line):
                fenced = not fenced
            elif not fenced:
                line = LINK.sub(lambda match: f"]({self.target(page, number, match[1])})", line)
            lines.append(line)
        self.write(page.relative_to(self.root), "\n".join(lines))

    def target(self, page, number, link):
        """What a link of the page becomes."""
        if re.match(r"[a-z]+:|#", link):
            return link
        name, mark, anchor = link.partition("#")
        file = pathlib.Path(os.path.normpath(page.parent / name))
        if self.root not in file.parents or not file.exists():
            self.faults.append(f"{page.relative_to(self.root)}:{number}: links to {name}, which is not there")
            return link
        place = file.relative_to(self.root)
        if file.is_dir() and (file / "README.md").exists():
            file, place = file / "README.md", place / "README.md"
        if file.suffix == ".md":
            self.todo.append(file)
        elif file.suffix in PICTURES:
            (self.pages / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, self.pages / place)
        elif place.parent == pathlib.Path("include/phymul"):
            place, mark, anchor = pathlib.Path("api") / (place.name.replace("_", "__").replace(".", "_8") + ".html"), "", ""
        elif place == pathlib.Path("include/phymul"):
            place = pathlib.Path("api/files.html")
        elif file.is_dir():
            place = self.show_folder(file, place)
        else:
            place = self.show_file(file, place)
        return os.path.relpath(place, page.parent.relative_to(self.root)) + mark + anchor

    def show_file(self, file, place):
        shown = place.with_name(place.name + ".md")
        # A fence longer than any in the file.
        self.write(shown, f"# {place}\n\n~~~~~~{LANGUAGES.get(file.suffix, 'text')}\n{file.read_text()}\n~~~~~~\n")
        return shown

    def show_folder(self, folder, place):
        rows = []
        for file in sorted(folder.iterdir()):
            if file.suffix == ".md":
                self.todo.append(file)
                rows.append(f"- [{file.name}]({file.name})")
            elif file.is_file():
                rows.append(f"- [{file.name}]({self.show_file(file, place / file.name).name})")
        self.write(place / "files.md", f"# {place}\n\n" + "\n".join(rows) + "\n")
        return place / "files.md"


def main(root, pages, navigation):
    root = pathlib.Path(root).resolve()
    pages = pathlib.Path(pages).resolve()
    gatherer = Gatherer(root, pages)
    gatherer.run()
    listed = pathlib.Path(navigation).read_text()
    for page in sorted(gatherer.done):
        place = page.relative_to(root)
        dated = place.match("docs/decisions/2*.md")  # listed by docs/decisions/README.md
        if place.parts[0] == "docs" and not dated and f": {place}\n" not in listed:
            gatherer.faults.append(f"{place}: {navigation} does not list it: add it to nav")
    shutil.copyfile(pathlib.Path(navigation).parent / "site.css", pages / "site.css")
    if gatherer.faults:
        sys.exit("\n".join(gatherer.faults))


if __name__ == "__main__":
    main(*sys.argv[1:])
