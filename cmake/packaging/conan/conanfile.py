# SPDX-License-Identifier: MIT
"""A recipe for Conan 2, run from the root of the tree: docs/guide/packages.md."""

import os

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Phymul(ConanFile):
    name = "phymul"
    version = "0.2.0"
    license = "MIT"
    description = "Soft tissue by the shape-memory particle model"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False], "surfaces": [True, False]}
    default_options = {"shared": False, "fPIC": True, "surfaces": False}
    implements = ["auto_shared_fpic"]

    def validate(self):
        check_min_cppstd(self, 20)  # the headers' needs too: Conan's own targets do not hand on what CMake's say

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)
        self.requires("pugixml/1.14")
        self.requires("zlib/[>=1.2.11 <2]")
        if self.options.surfaces:
            self.requires("assimp/5.4.3")

    def layout(self):
        cmake_layout(self)

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "glsl/*", "include/*", "src/*"):
            copy(self, pattern, src=root, dst=self.export_sources_folder)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for option in ("BUILD_TESTS", "BUILD_BENCH", "BUILD_EXAMPLES", "WITH_C", "WITH_GL", "WITH_LABELS"):
            toolchain.cache_variables[f"PHYMUL_{option}"] = "OFF"
        toolchain.cache_variables["PHYMUL_WITH_ASSIMP"] = "ON" if self.options.surfaces else "OFF"
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        self.cpp_info.set_property("cmake_target_name", "phymul::phymul")
        self.cpp_info.set_property("cmake_config_version_compat", "SameMinorVersion")
        self.cpp_info.libs = ["phymul"]
        if self.settings.os == "Linux":
            self.cpp_info.system_libs = ["pthread", "dl"]
