"""Conan 2 recipe of the clone that this file lies in."""

import os

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Planish(ConanFile):
    name = "planish"
    version = "0.1.0"
    license = "MIT"
    description = "Interpolating Doo-Sabin subdivision surfaces through the points of polygon meshes"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False]}
    default_options = {"shared": False}
    requires = (
        "glm/[>=0.9.9]",
        "meshoptimizer/[>=0.18]",
        "nlohmann_json/[>=3.11]",
        "onetbb/[>=2021.8]",
        "opensubdiv/[>=3.5]",
        "tinygltf/[>=2.5]",
    )

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "src/*", "shaders/*", "tools/*"):
            copy(self, pattern, root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for name in ("VULKAN", "RECONSTRUCT", "PYTHON", "TESTS", "BENCH"):
            toolchain.cache_variables[f"PLANISH_{name}"] = False
        toolchain.cache_variables["PLANISH_LIBRARY_ONLY"] = True
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "planish")]
