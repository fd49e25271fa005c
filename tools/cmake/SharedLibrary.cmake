# What the libraries need to be shared, or part of one: code that can be loaded anywhere, where no
# function is taken to be replaced by another library's, so that it is as fast as without.
if(BUILD_SHARED_LIBS OR PLANISH_PYTHON)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
  if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    add_compile_options(-fno-semantic-interposition)
  endif()
endif()

# planish_shared(TARGET): version, and no symbols but planish's own. Before 1.0 a minor version may
# change the interface, so that it is part of the name that programs ask for.
function(planish_shared target)
  set_target_properties(${target} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    DEFINE_SYMBOL "")
  if(BUILD_SHARED_LIBS AND NOT APPLE)  # whose linker takes no such lists
    set(map ${PROJECT_SOURCE_DIR}/tools/cmake/exported_symbols.map)
    target_link_options(${target} PRIVATE "LINKER:--version-script=${map}" LINKER:--no-undefined)
    set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${map})
  endif()
endfunction()

# planish_portable(TARGET): a program that, in the build tree and wherever it is copied from there, finds
# libraries in ../lib first. The older of the two tags holds for libraries of libraries, too.
# Installed, it has what CMAKE_INSTALL_RPATH says.
function(planish_portable target)
  if(WIN32)  # whose programs look beside themselves
    return()
  endif()
  if(APPLE)
    set_target_properties(${target} PROPERTIES BUILD_RPATH "@loader_path/../lib")
    return()
  endif()
  set_target_properties(${target} PROPERTIES BUILD_RPATH "\$ORIGIN/../lib")
  target_link_options(${target} PRIVATE LINKER:--disable-new-dtags)
endfunction()
