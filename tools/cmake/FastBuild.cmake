# Less waiting for the compiler: sources compiled several at once, and headers compiled before.
# A source that forgets an include may compile all the same, so that CI builds without.
option(PLANISH_FAST_BUILD "Unity builds and precompiled headers; OFF finds missing includes" ON)

# GCC collects its garbage from 128 MiB on, again and again in sources of this size: a tenth of its time.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=524288>")
endif()
# Sources of a library are compiled before those that it links are whole.
set(CMAKE_OPTIMIZE_DEPENDENCIES ON)

# planish_unite(TARGET SIZE [ALONE SOURCE...]): the target's sources are compiled SIZE at a time, but
# for main.cpp, those named, and those with compile options of their own, to which CMake sees.
function(planish_unite target size)
  if(PLANISH_FAST_BUILD)
    cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "ALONE")
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${size})
    set_source_files_properties(main.cpp ${arg_ALONE} TARGET_DIRECTORY ${target}
                                PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# planish_unite_group(TARGET GROUP SIZE SOURCE...): these sources of the current folder only.
function(planish_unite_group target group size)
  if(NOT PLANISH_FAST_BUILD)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  list(FILTER ARGN INCLUDE REGEX "\\.cpp$")
  set(at 0)
  foreach(source IN LISTS ARGN)
    math(EXPR number "${at} / ${size}")
    math(EXPR at "${at} + 1")
    set_source_files_properties(${source} TARGET_DIRECTORY ${target}
                                PROPERTIES UNITY_GROUP ${group}_${number})
  endforeach()
endfunction()

# planish_precompile(TARGET HEADER...): each as it stands between the <> of an include; or those of
# another target, built with the same options: planish_precompile(TARGET REUSE_FROM OTHER).
# Not where a compiler cache is used, for which precompiled headers are inputs that change with every build.
function(planish_precompile target)
  if(NOT PLANISH_FAST_BUILD OR CMAKE_CXX_COMPILER_LAUNCHER)
    return()
  endif()
  if(ARGV1 STREQUAL REUSE_FROM)
    target_precompile_headers(${target} REUSE_FROM ${ARGV2})
    # GCC takes none where a macro is missing that was defined before, such as those of private libraries.
    target_compile_definitions(${target} PRIVATE "$<TARGET_PROPERTY:${ARGV2},COMPILE_DEFINITIONS>")
    get_target_property(type ${target} TYPE)
    if(type STREQUAL EXECUTABLE)
      # Else the library's objects and the executable's are compiled differently.
      set_target_properties(${target} ${ARGV2} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    endif()
    return()
  endif()
  list(TRANSFORM ARGN REPLACE "(.+)" "<\\1>")
  target_precompile_headers(${target} PRIVATE ${ARGN})
endfunction()

# planish_optimise_less(TARGET): for what parses flags and writes JSON, and has no loop to speed up. -Og
# takes two thirds of the time of -O1.
function(planish_optimise_less target)
  target_compile_options(${target} PRIVATE "$<$<NOT:$<OR:$<CONFIG:Debug>,$<PLATFORM_ID:Emscripten>>>:-Og>")
endfunction()

# planish_optimise_group_less(TARGET GROUP SIZE SOURCE...): these sources of a target only, as
# planish_unite_group() has them: -O1, half of the time of -O3. Options of the sources themselves would keep
# CMake from uniting them, so that those that it writes have the option. They go without the headers that were
# precompiled for -O3: GCC 13 and later refuse them, and they save an -O1 source a sixth of its time.
function(planish_optimise_group_less target group size)
  list(FILTER ARGN INCLUDE REGEX "\\.cpp$")
  if(NOT ARGN)
    return()
  endif()
  set(sources ${ARGN})
  if(PLANISH_FAST_BUILD)
    get_target_property(folder ${target} BINARY_DIR)
    list(LENGTH sources count)
    math(EXPR last "(${count} - 1) / ${size}")
    set(sources "")
    foreach(number RANGE ${last})
      list(APPEND sources ${folder}/CMakeFiles/${target}.dir/Unity/unity_${group}_${number}_cxx.cxx)
    endforeach()
  endif()
  set_source_files_properties(${sources} TARGET_DIRECTORY ${target} PROPERTIES COMPILE_OPTIONS
                              "$<$<NOT:$<OR:$<CONFIG:Debug>,$<PLATFORM_ID:Emscripten>>>:-O1>"
                              SKIP_PRECOMPILE_HEADERS ON)
endfunction()
