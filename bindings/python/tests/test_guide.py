# SPDX-License-Identifier: MIT
"""What the guides show works: the Python of docs/guide/python.md runs from top to bottom, and docs/guide/c.md shows
lines of bindings/c/example.c."""

import os
import pathlib
import re
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / "docs/guide" / page).read_text(), re.S)


class Guides(unittest.TestCase):
    def test_python_runs(self):
        parts = blocks("python.md", "python")
        self.assertGreater(len(parts), 3)
        names = {}
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                for number, part in enumerate(parts, 1):
                    exec(compile(part, f"python.md, block {number}", "exec"), names)
            finally:
                os.chdir(before)

    def test_c_is_quoted(self):
        parts = blocks("c.md", "c")
        self.assertGreater(len(parts), 0)
        for part in parts:
            self.assertIn(part, (ROOT / "bindings/c/example.c").read_text())


if __name__ == "__main__":
    unittest.main()
