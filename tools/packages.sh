# Sourced by tools/run, tools/test, tools/package, tools/docs, tools/races and tools/check: the packages of Debian 12,
# Debian 13 and Ubuntu 24.04 that each needs. Of names with | between, the first that the system has.

# To build the command and the library.
run_packages="g++ cmake ninja-build libosd-dev libglm-dev libtbb-dev libtinygltf-dev libmeshoptimizer-dev libdraco-dev
  nlohmann-json3-dev libcli11-dev libssl-dev zlib1g-dev libstb-dev libvulkan-dev glslang-tools spirv-tools libcgal-dev"

# To build and run the tests and benchmarks: reference implementations, a software Vulkan device
# and its validation layers.
test_packages="libgtest-dev libgmock-dev libbenchmark-dev libeigen3-dev libegl-dev
  libtinyobjloader-dev mesa-vulkan-drivers vulkan-validationlayers xvfb python3 zsh fish man-db bsdextrautils
  xz-utils git"

# The glTF validator and the tests of pages' code.
node_packages="nodejs npm"

# To test pages in a browser: 64 MB to fetch, so only where the test must not be skipped. Not in Ubuntu, where
# PLANISH_BROWSER may name a Chromium.
browser_packages="chromium-headless-shell"

# To build the viewer.
viewer_packages="libglfw3-dev libimgui-dev"

# To build planish-mpi and to test it over ranks.
mpi_packages="petsc64-dev libopenmpi-dev openmpi-bin pkg-config"

# To build the Python module, and to run its tests and example.
python_packages="python3-dev pybind11-dev"
python_test_packages="python3-numpy python3-pytest python3-matplotlib mypy python3-pip"

# To make the reference pages.
docs_packages="doxygen graphviz"

# To check format and faults.
check_packages="clang-format-14|clang-format clang-tidy"

# To build oneTBB and all else with the thread sanitizer.
races_packages="clang-19 dpkg-dev patch"

# To compile to WebAssembly, beside what tools/wasm/setup.sh fetches; and the packages whose sources are compiled so.
wasm_packages="clang-19 lld-19 llvm-19 dpkg-dev cmake ninja-build python3 libosd-dev libglm-dev libtinygltf-dev
  libmeshoptimizer-dev nlohmann-json3-dev libcli11-dev zlib1g-dev libstb-dev"
wasm_sources="libosd-dev libmeshoptimizer-dev zlib1g-dev"

# To compile for arm64 Linux on x86-64 and to run that; and what it links, of the other architecture.
arm64_packages="g++-aarch64-linux-gnu qemu-user-static"
arm64_libraries="libosd-dev libtbb-dev libtinygltf-dev libmeshoptimizer-dev libdraco-dev libstb-dev zlib1g-dev libssl-dev
  libgtest-dev libgmock-dev libtinyobjloader-dev"

# To compile for Windows and to run that; by clang with libc++; and, for both, the packages whose sources are compiled so.
windows_packages="g++-mingw-w64-x86-64-posix wine64 wine"
libcxx_packages="clang-19 lld-19 libc++-19-dev libc++abi-19-dev"
toolchain_packages="dpkg-dev cmake ninja-build python3 libosd-dev libglm-dev libtbb-dev
  libtinygltf-dev libmeshoptimizer-dev nlohmann-json3-dev libcli11-dev zlib1g-dev libstb-dev libgtest-dev
  libtinyobjloader-dev libeigen3-dev"
toolchain_sources="libosd-dev libmeshoptimizer-dev zlib1g-dev libtbb-dev"
