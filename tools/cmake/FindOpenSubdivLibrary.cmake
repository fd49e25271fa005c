# Finds OpenSubdiv's shared CPU library. OpenSubdiv's own package file on Debian names static
# libraries that libosd-dev does not ship, and stops the configuration; so look for the parts.
# Defines the target OpenSubdiv::osdCPU.
find_path(OpenSubdivLibrary_INCLUDE_DIR opensubdiv/far/topologyRefiner.h)
find_library(OpenSubdivLibrary_osdCPU osdCPU)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenSubdivLibrary
  REQUIRED_VARS OpenSubdivLibrary_osdCPU OpenSubdivLibrary_INCLUDE_DIR)
if(OpenSubdivLibrary_FOUND AND NOT TARGET OpenSubdiv::osdCPU)
  add_library(OpenSubdiv::osdCPU UNKNOWN IMPORTED)
  set_target_properties(OpenSubdiv::osdCPU PROPERTIES
    IMPORTED_LOCATION "${OpenSubdivLibrary_osdCPU}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenSubdivLibrary_INCLUDE_DIR}")
endif()
mark_as_advanced(OpenSubdivLibrary_INCLUDE_DIR OpenSubdivLibrary_osdCPU)
