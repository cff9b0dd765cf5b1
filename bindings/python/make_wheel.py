# SPDX-License-Identifier: MIT
"""Packs the package as a wheel, with the standard library alone. make_wheel.py <package folder>
<name>-<version>-<tags>.whl, or by pip (pyproject.toml), which calls build_wheel(). The format:
https://packaging.python.org/en/latest/specifications/binary-distribution-format/"""

import base64
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import zipfile


def pack(package, wheel):
    name, version, *tags = wheel.stem.split("-")
    info = f"{name}-{version}.dist-info"
    files = {f"{name}/{file.relative_to(package)}": file.read_bytes()
             for file in sorted(package.rglob("*")) if file.is_file() and file.suffix != ".pyc"}
    files[f"{info}/METADATA"] = (f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
                                 "Summary: Deforms soft tissue for simulators\nLicense: MIT\n"
                                 "Requires-Python: >=3.9\nRequires-Dist: numpy\n").encode()
    files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: {name}\nRoot-Is-Purelib: false\n"
                              f"Tag: {'-'.join(tags)}\n").encode()
    record = ""
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record += f"{path},sha256={digest},{len(content)}\n"
            archive.writestr(zipfile.ZipInfo(path, (2026, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)
        archive.writestr(zipfile.ZipInfo(f"{info}/RECORD", (2026, 1, 1, 0, 0, 0)), record + f"{info}/RECORD,,\n")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """What pip calls for `pip install .` (PEP 517). `--config-settings build-dir=<folder>` uses a build that exists."""
    root = pathlib.Path(__file__).resolve().parents[2]
    with tempfile.TemporaryDirectory() as own:
        build = pathlib.Path((config_settings or {}).get("build-dir", own))
        if not (build / "CMakeCache.txt").exists():
            parts = [f"-DPHYMUL_BUILD_{part}=OFF" for part in ("TESTS", "BENCH", "EXAMPLES")]
            subprocess.run(["cmake", "-S", root, "-B", build, "-DCMAKE_BUILD_TYPE=Release", *parts], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "python_wheel", "--parallel", str(os.cpu_count())],
                       check=True)
        wheel = max(build.glob("phymul-*.whl"), key=lambda file: file.stat().st_mtime)  # earlier versions stay there
        shutil.copy(wheel, wheel_directory)
        return wheel.name


if __name__ == "__main__":
    pack(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
