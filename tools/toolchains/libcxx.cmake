# Builds on x86-64 Linux by clang 19 with LLVM's C++ library, as macOS has it, with what tools/toolchains/setup.sh libcxx puts
# into $PLANISH_LIBCXX: libraries of Debian's own speak the C++ library of GCC.
if(DEFINED ENV{PLANISH_LIBCXX})
  set(planish_libcxx $ENV{PLANISH_LIBCXX})
else()
  set(planish_libcxx $ENV{HOME}/.cache/planish-libcxx)
endif()
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_CXX_FLAGS_INIT "-stdlib=libc++ -isystem ${planish_libcxx}/prefix/include")
set(CMAKE_EXE_LINKER_FLAGS_INIT -fuse-ld=lld)
set(CMAKE_PREFIX_PATH ${planish_libcxx}/prefix)
