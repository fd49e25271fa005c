# Builds on x86-64 for arm64, with the packages of Debian's or Ubuntu's other architecture; tests run under QEMU:
#   dpkg --add-architecture arm64; apt update; apt install g++-aarch64-linux-gnu qemu-user-static libosd-dev:arm64
#     libtbb-dev:arm64 libtinygltf-dev:arm64 libmeshoptimizer-dev:arm64 libdraco-dev:arm64 libstb-dev:arm64
#     zlib1g-dev:arm64 libssl-dev:arm64 libgtest-dev:arm64 libgmock-dev:arm64 libtinyobjloader-dev:arm64
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# Also runs what is built to build the rest.
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)
