# The installed package: find_package(planish) gives planish::planish; pkg-config gives `planish`. The
# mesher of points that it starts is the GPL-3 program planish-reconstruct. Components: runtime, development, command, viewer, python, blender, mpi.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/planish)
install(TARGETS planish EXPORT planishTargets
        LIBRARY COMPONENT runtime NAMELINK_COMPONENT development
        ARCHIVE COMPONENT development RUNTIME COMPONENT runtime)
# What users include: the whole way, hosts in C, the points of surfaces piece by piece, the matrix of
# the interpolation with OpenSubdiv's form of it, points, Vulkan and OpenSubdiv on it.
set(public_headers
  planish.h c/editor.h c/planish.h
  mesh/statistics.h surface/kept_rows.h surface/quality_sum.h
  doosabin/limit_masks.h solve/far_tables.h
  reconstruct/reconstruct.h reconstruct/compare_source.h reconstruct/mesher_process.h)
if(PLANISH_VULKAN)
  list(APPEND public_headers
    vulkan/embed.h vulkan/vulkan_backend.h vulkan/device/own_device.h
    osd/vk_compute_evaluator.h osd/vk_device_context.h osd/vk_patch_evaluator.h
    osd/vk_patch_shader_source.h osd/vk_patch_table.h osd/vk_stencil_table.h
    osd/vk_vertex_buffer.h)
endif()
list(TRANSFORM public_headers PREPEND planish/)
list(JOIN public_headers " " public_headers)
install(CODE "include(\"${CMAKE_CURRENT_LIST_DIR}/PublicHeaders.cmake\")
planish_install_headers(\"${PROJECT_SOURCE_DIR}/src\"
  \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\" ${public_headers})"
        COMPONENT development)
if(PLANISH_VULKAN)
  # The surface, and OpenSubdiv's patches, as shader code: planish_SHADER_DIR of the package.
  install(FILES shaders/surface/planish_surface.glsl shaders/surface/planish_surface_tables.h
                shaders/surface/finite.glsl shaders/surface/unit_normal.glsl
                shaders/osd/planish_osd_patches.glsl shaders/osd/planish_osd_tessellation.glsl
          DESTINATION ${CMAKE_INSTALL_DATADIR}/planish/shaders COMPONENT development)
endif()
install(EXPORT planishTargets NAMESPACE planish:: DESTINATION ${package_dir}
        COMPONENT development)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/planishConfig.cmake.in
  ${PROJECT_BINARY_DIR}/planishConfig.cmake INSTALL_DESTINATION ${package_dir}
  PATH_VARS CMAKE_INSTALL_DATADIR)
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/planishConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/planishConfig.cmake
              ${PROJECT_BINARY_DIR}/planishConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/FindOpenSubdivLibrary.cmake
        DESTINATION ${package_dir} COMPONENT development)

# For builds without CMake. A shared library brings what it needs itself; OpenSubdiv has no .pc file.
set(pc_libs_private "")
if(NOT BUILD_SHARED_LIBS)
  set(pc_libs_private "-losdCPU -lmeshoptimizer -lcrypto -lz -lstdc++ -lm")
  if(PLANISH_DRACO)
    string(PREPEND pc_libs_private "-ldraco ")
  endif()
endif()
# Found from where the file lies, so that an installation can be moved.
file(RELATIVE_PATH pc_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" pc_prefix "${pc_prefix}")
configure_file(${CMAKE_CURRENT_LIST_DIR}/planish.pc.in ${PROJECT_BINARY_DIR}/planish.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/planish.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT development)
