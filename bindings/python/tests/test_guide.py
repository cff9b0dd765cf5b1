# SPDX-License-Identifier: MIT
"""What the guide shows works: the Python of docs/guide/python.md runs from top to bottom. (Code of other languages:
tests/checks/pages.cmake.)"""

import os
import pathlib
import re
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]


class Guide(unittest.TestCase):
    def test_python_runs(self):
        parts = re.findall(r"```python\n(.*?)```", (ROOT / "docs/guide/python.md").read_text(), re.S)
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


if __name__ == "__main__":
    unittest.main()
