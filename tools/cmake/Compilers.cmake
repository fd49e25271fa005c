# Compilers and systems that planish is not written for, by their names and before they fail in the midst of a build.
if(MSVC)
  message(FATAL_ERROR "Visual Studio's cl and clang-cl do not compile planish: its vectors, attributes and options are "
          "GCC's. mingw-w64's GCC does, on Linux by `cmake --preset windows` after tools/toolchains/setup.sh windows; programs of "
          "Visual Studio can use the planish.dll and planish.lib that it makes.")
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 16)
  message(FATAL_ERROR "Clang ${CMAKE_CXX_COMPILER_VERSION} lacks parts of C++20 that planish uses; take 16 or later "
          "(-DCMAKE_CXX_COMPILER=clang++-19, or the preset clang), or GCC 12 or later.")
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 12)
  message(FATAL_ERROR "GCC ${CMAKE_CXX_COMPILER_VERSION} lacks parts of C++20 that planish uses; take 12 or later.")
endif()
if(NOT EMSCRIPTEN AND CMAKE_SIZEOF_VOID_P EQUAL 4)
  message(FATAL_ERROR "planish wants a system of 64 bits: its files and arrays are larger than 32 bits can count.")
endif()
