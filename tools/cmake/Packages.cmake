# What cpack makes: Debian packages, one for each component. tools/package calls it.
set(CPACK_PACKAGE_NAME planish)
set(CPACK_PACKAGE_VENDOR "The planish authors")
# Each package has a synopsis of its own; one for all would stand before it.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
if(CMAKE_CROSSCOMPILING AND CMAKE_SYSTEM_PROCESSOR STREQUAL aarch64)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)  # not this machine's
endif()
# Who packages, as Debian's own tools ask for it.
set(PLANISH_PACKAGER "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>" CACHE STRING "Maintainer of packages")
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${PLANISH_PACKAGER}")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src/planish
    ${PROJECT_BINARY_DIR}/src/planish/reconstruct)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
# The loader's cache is made anew by a trigger, as Debian wants it.
file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/DebianFiles.cmake)
set(CPACK_PLANISH_SOURCE ${PROJECT_SOURCE_DIR})

set(soname ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(library libplanish${soname})
set(same "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
# planish_package(COMPONENT NAME SECTION DEPENDS SUMMARY DESCRIPTION)
macro(planish_package component name section depends summary description)
  string(TOUPPER ${component} upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}")
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${description}")
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${description}")
endmacro()
set(CPACK_COMPONENTS_ALL)
set(vulkan_headers)
if(PLANISH_VULKAN)
  set(vulkan_headers ", libvulkan-dev")
endif()
planish_package(runtime ${library} libs ""
  "smooth surfaces through the points of polygon meshes - library"
  "Finds the control cage whose subdivision surface passes through all vertices
of a mesh, and evaluates that surface with exact normals, on the CPU or on
Vulkan. This is the shared library.")
planish_package(development libplanish-dev libdevel
  "${library} ${same}, libosd-dev, libglm-dev, libtbb-dev${vulkan_headers}"
  "smooth surfaces through the points of polygon meshes - headers"
  "The interfaces for C++ and C, and the files by which CMake and pkg-config
find the library.")
planish_package(command planish graphics "${library} ${same}"
  "smooth surfaces through the points of polygon meshes - command"
  "Reads meshes (OBJ, PLY, OFF, STL, glTF) and points, and writes the smooth
surface through all of them as glTF, OBJ, PLY, STL or USD. With the program
planish-reconstruct, which makes meshes of points and is under the GPL.")
if(PLANISH_VIEWER)
  planish_package(viewer planish-viewer graphics "${library} ${same}"
    "smooth surfaces through the points of polygon meshes - viewer"
    "Animates a mesh and its interpolating surface on a Vulkan device, in a
window or into pictures.")
endif()
if(PLANISH_PYTHON)
  set(python ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR})
  math(EXPR next "${Python3_VERSION_MINOR} + 1")
  planish_package(python python3-planish python
    "${library} ${same}, python3 (>= ${python}), python3 (<< ${Python3_VERSION_MAJOR}.${next}), python3-numpy"
    "smooth surfaces through the points of polygon meshes - Python"
    "The module planish: meshes and surfaces as numpy arrays.")
endif()
planish_package(blender planish-blender graphics "planish ${same}, blender, python3-numpy"
  "smooth surfaces through the points of polygon meshes - Blender add-on"
  "A panel in the sidebar of Blender's 3-D view, which makes smooth surfaces
through all vertices of the selected meshes. It is enabled in the
preferences, under Add-ons.")
set(CPACK_DEBIAN_BLENDER_PACKAGE_ARCHITECTURE all)
include(CPack)
