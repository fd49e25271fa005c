# Builds for Windows 10 and later on x86-64 Linux by Debian's mingw-w64, with what tools/toolchains/setup.sh windows puts into
# $PLANISH_WINDOWS; programs and the library for C need nothing but the system's own, and run under Wine.
if(DEFINED ENV{PLANISH_WINDOWS})
  set(planish_windows $ENV{PLANISH_WINDOWS})
else()
  set(planish_windows $ENV{HOME}/.cache/planish-windows)
endif()
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR AMD64)
# With the threads of C++, which the other of its two lacks.
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
# A stack as Linux has it: 1 MiB is usual.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static -Wl,--stack,8388608")
set(CMAKE_SHARED_LINKER_FLAGS_INIT -static)
# Windows 10; and M_PI, which headers of OpenSubdiv use.
set(planish_flags "-D_WIN32_WINNT=0x0A00 -D_USE_MATH_DEFINES")
set(CMAKE_C_FLAGS_INIT "${planish_flags}")
set(CMAKE_CXX_FLAGS_INIT "${planish_flags} -isystem ${planish_windows}/prefix/include")
# Also runs what is built to build the rest, and tests.
set(CMAKE_CROSSCOMPILING_EMULATOR wine)
set(CMAKE_FIND_ROOT_PATH ${planish_windows}/prefix)
set(CMAKE_PREFIX_PATH ${planish_windows}/prefix)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(Eigen3_DIR /usr/share/eigen3/cmake)  # headers alone, of tests
