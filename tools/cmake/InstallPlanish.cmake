# The installed package: find_package(planish) gives planish::planish, and planish::reconstruct for
# points (MIT too; the mesher that it starts is the GPL-3 program planish-reconstruct).
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/planish)
install(TARGETS planish planish_reconstruct EXPORT planishTargets ARCHIVE LIBRARY RUNTIME
        FILE_SET HEADERS)
install(EXPORT planishTargets NAMESPACE planish:: DESTINATION ${package_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/planishConfig.cmake.in
  ${PROJECT_BINARY_DIR}/planishConfig.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/planishConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/planishConfig.cmake
              ${PROJECT_BINARY_DIR}/planishConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/FindOpenSubdivLibrary.cmake
        DESTINATION ${package_dir})
