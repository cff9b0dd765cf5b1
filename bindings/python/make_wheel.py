# SPDX-License-Identifier: MIT
"""make_wheel.py <package folder> <name>-<version>-<tags>.whl: packs the package as a wheel, with the standard library
alone. The format: https://packaging.python.org/en/latest/specifications/binary-distribution-format/"""

import base64
import hashlib
import pathlib
import sys
import zipfile

package, wheel = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
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
print(wheel)
