# cmake -DSOURCE=... -DFOLDER=... -P check_config.cmake: what find_package(planish) asks for. Of a shared library
# only what its headers include; a static one is linked together with what its sources use.
cmake_minimum_required(VERSION 3.25)
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_PREFIX ${FOLDER})
file(REMOVE_RECURSE ${FOLDER})
# In the place of CMake's own: notes what is asked for.
file(WRITE ${FOLDER}/CMakeFindDependencyMacro.cmake
     "macro(find_dependency name)\n  list(APPEND asked \${name})\nendmacro()\n")

# expect_asked(SHARED DRACO PACKAGE...)
function(expect_asked BUILD_SHARED_LIBS PLANISH_DRACO)
  configure_package_config_file(${SOURCE}/tools/cmake/planishConfig.cmake.in ${FOLDER}/planishConfig.cmake
                                INSTALL_DESTINATION lib/cmake/planish)
  file(WRITE ${FOLDER}/planishTargets.cmake "")
  set(CMAKE_MODULE_PATH ${FOLDER})
  set(asked)
  include(${FOLDER}/planishConfig.cmake)
  if(NOT "${asked}" STREQUAL "${ARGN}")
    message(FATAL_ERROR "shared ${BUILD_SHARED_LIBS}, Draco ${PLANISH_DRACO}: asks for ${asked}, not ${ARGN}")
  endif()
endfunction()

set(public OpenSubdivLibrary glm TBB)
expect_asked(ON ON ${public})
expect_asked(ON OFF ${public})
expect_asked(OFF ON ${public} meshoptimizer OpenSSL ZLIB draco)
expect_asked(OFF OFF ${public} meshoptimizer OpenSSL ZLIB)
