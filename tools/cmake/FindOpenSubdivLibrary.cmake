# Finds OpenSubdiv's shared CPU library. OpenSubdiv's own package file on Debian names static
# libraries that libosd-dev does not ship, and stops the configuration; so look for the parts.
# Defines the target OpenSubdiv::osdCPU, and OpenSubdiv::osdGPU where there is one.
find_path(OpenSubdivLibrary_INCLUDE_DIR opensubdiv/far/topologyRefiner.h)
find_library(OpenSubdivLibrary_osdCPU osdCPU)
find_library(OpenSubdivLibrary_osdGPU osdGPU)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenSubdivLibrary
  REQUIRED_VARS OpenSubdivLibrary_osdCPU OpenSubdivLibrary_INCLUDE_DIR)
if(OpenSubdivLibrary_FOUND AND NOT TARGET OpenSubdiv::osdCPU)
  add_library(OpenSubdiv::osdCPU UNKNOWN IMPORTED)
  set_target_properties(OpenSubdiv::osdCPU PROPERTIES
    IMPORTED_LOCATION "${OpenSubdivLibrary_osdCPU}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenSubdivLibrary_INCLUDE_DIR}")
endif()
if(OpenSubdivLibrary_osdGPU AND TARGET OpenSubdiv::osdCPU AND NOT TARGET OpenSubdiv::osdGPU)
  add_library(OpenSubdiv::osdGPU UNKNOWN IMPORTED)
  set_target_properties(OpenSubdiv::osdGPU PROPERTIES
    IMPORTED_LOCATION "${OpenSubdivLibrary_osdGPU}"
    INTERFACE_LINK_LIBRARIES OpenSubdiv::osdCPU)
endif()
mark_as_advanced(OpenSubdivLibrary_INCLUDE_DIR OpenSubdivLibrary_osdCPU OpenSubdivLibrary_osdGPU)
