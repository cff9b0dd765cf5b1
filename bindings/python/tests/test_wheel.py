# SPDX-License-Identifier: MIT
"""test_wheel.py <build folder>: makes the wheel, installs the source tree by pip in an empty folder, and uses it
there."""

import base64
import csv
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile
import zipfile

root = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(root / "bindings/python"))
import make_wheel

build = sys.argv[1]
program = "import phymul; print(phymul.__file__, len(phymul.make_block((1, 1, 1), 2, 2, 2).rest))"

earlier = pathlib.Path(build) / "phymul-0.0.1-py3-none-any.whl"  # that the build made of another version
earlier.touch()
os.utime(earlier, (0, 0))
with tempfile.TemporaryDirectory() as folder:
    site = pathlib.Path(folder) / "site"
    wheel = pathlib.Path(folder) / make_wheel.build_wheel(folder, {"build-dir": build})
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        record = next(name for name in names if name.endswith(".dist-info/RECORD"))
        rows = list(csv.reader(archive.read(record).decode().splitlines()))
        assert sorted(row[0] for row in rows) == sorted(names), "RECORD lists other files than there are"
        for path, digest, size in rows[:-1]:
            content = archive.read(path)
            found = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            assert (digest, size) == (f"sha256={found}", str(len(content))), path
        has_pip = subprocess.run([sys.executable, "-m", "pip", "--version"], stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL).returncode == 0
        if not has_pip:
            archive.extractall(site)  # what pip does with a wheel of this kind
    if has_pip:
        subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index",
                        "--no-build-isolation", "--disable-pip-version-check", "--config-settings",
                        f"build-dir={build}", "--target", site, root], check=True)
    environment = {**os.environ, "PYTHONPATH": str(site)}
    output = subprocess.run([sys.executable, "-c", program], env=environment, cwd=folder, check=True, text=True,
                            stdout=subprocess.PIPE).stdout
    assert output.split() == [str(site / "phymul/__init__.py"), "27"], output
    print("installed with pip" if has_pip else "unpacked: this Python has no pip")
earlier.unlink()
