# Warnings and sanitizers for our own targets; installed consumers see none of it.
add_library(planish_options INTERFACE)
target_compile_options(planish_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wno-missing-field-initializers)
if(PLANISH_SANITIZE)
  # OpenSubdiv casts a base table to LimitStencilTable, which the vptr check reports.
  target_compile_options(planish_options INTERFACE -fsanitize=${PLANISH_SANITIZE} -fno-sanitize=vptr
                         -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  # std::clamp() with its bounds turned round, an empty vector's front(), and the like.
  target_compile_definitions(planish_options INTERFACE _GLIBCXX_ASSERTIONS)
  # GCC's macros, which Clang does not have: what a sanitizer takes is not what tests of memory measure.
  foreach(sanitizer address thread)
    if(CMAKE_CXX_COMPILER_ID MATCHES Clang AND PLANISH_SANITIZE MATCHES ${sanitizer})
      string(TOUPPER __SANITIZE_${sanitizer}__ macro)
      target_compile_definitions(planish_options INTERFACE ${macro})
    endif()
  endforeach()
  target_link_options(planish_options INTERFACE -fsanitize=${PLANISH_SANITIZE})
endif()

# planish_include_quoted(TARGET SCOPE FOLDER...): where our #include "..." looks. #include <...> does not, for a folder may
# have a file of a standard header's name.
function(planish_include_quoted target scope)
  list(TRANSFORM ARGN PREPEND -iquote)
  target_compile_options(${target} ${scope} ${ARGN})
endfunction()

# planish_require_instrumented(TARGET): of a library whose locks the thread sanitizer must see, as else every loop on it
# looks like a race, or, where what stands in it is not reported, none does.
function(planish_require_instrumented target)
  if(NOT PLANISH_SANITIZE MATCHES thread)
    return()
  endif()
  get_target_property(location ${target} LOCATION)
  file(STRINGS ${location} calls REGEX "__tsan_func_entry" LIMIT_COUNT 1)
  if(NOT calls)
    message(FATAL_ERROR "${location} is not built with the thread sanitizer; tools/races builds one that is, or name "
                        "its folder by TBB_DIR")
  endif()
endfunction()

# planish_widest(TARGET SOURCE...): loops become vectors, of several widths with the same bits (core/widest.h).
function(planish_widest target)
  set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES COMPILE_OPTIONS
                              "-O3;-fno-math-errno;-fno-trapping-math"
                              SKIP_PRECOMPILE_HEADERS ON)
endfunction()
