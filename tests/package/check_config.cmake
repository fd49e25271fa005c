# cmake -DSOURCE=... -DFOLDER=... -P check_config.cmake: what find_package(planish) asks for. Of a shared library
# only what its headers include; a static one is linked together with what its sources use.
cmake_minimum_required(VERSION 3.25)
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_PREFIX ${FOLDER})
file(REMOVE_RECURSE ${FOLDER})
# In the place of CMake's own: notes what is asked for.
file(WRITE ${FOLDER}/CMakeFindDependencyMacro.cmake
     "macro(find_dependency name)\n  list(APPEND asked \${name})\nendmacro()\n")

# In a script there are no targets; components are told from their variables.
function(add_library)
endfunction()
function(target_link_libraries)
endfunction()

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

# expect_found(VULKAN FOUND COMPONENT...): whether a program that needs these components finds the package.
function(expect_found PLANISH_VULKAN found)
  set(BUILD_SHARED_LIBS ON)
  configure_package_config_file(${SOURCE}/tools/cmake/planishConfig.cmake.in ${FOLDER}/planishConfig.cmake
                                INSTALL_DESTINATION lib/cmake/planish)
  set(CMAKE_MODULE_PATH ${FOLDER})
  set(asked)
  set(planish_FOUND TRUE)
  set(planish_FIND_COMPONENTS ${ARGN})
  foreach(component IN LISTS ARGN)
    set(planish_FIND_REQUIRED_${component} TRUE)
  endforeach()
  include(${FOLDER}/planishConfig.cmake)
  if(NOT planish_FOUND STREQUAL found)
    message(FATAL_ERROR "Vulkan ${PLANISH_VULKAN}, components ${ARGN}: found is ${planish_FOUND}, not ${found}")
  endif()
endfunction()

expect_found(ON TRUE core formats points job gpu)
expect_found(OFF TRUE core job)
expect_found(OFF FALSE gpu)
expect_found(ON FALSE printer)
