# Emscripten as tools/wasm/setup.sh puts it into $PLANISH_WASM, or, with EMSDK set, that of an emsdk (3.1.60 or later).
if(DEFINED ENV{PLANISH_WASM})
  set(planish_wasm $ENV{PLANISH_WASM})
else()
  set(planish_wasm $ENV{HOME}/.cache/planish-wasm)
endif()
if(DEFINED ENV{EMSDK})
  set(EMSCRIPTEN_ROOT_PATH $ENV{EMSDK}/upstream/emscripten)
else()
  set(EMSCRIPTEN_ROOT_PATH ${planish_wasm}/emscripten/usr/share/emscripten)
endif()
if(NOT EXISTS ${EMSCRIPTEN_ROOT_PATH})
  message(FATAL_ERROR "${EMSCRIPTEN_ROOT_PATH} is not there; tools/wasm/setup.sh makes it")
endif()
set(NODE_JS_EXECUTABLE node)

# As native builds: nothing is fused, and no one asks for errno. Exceptions are the engine's own. libc++'s other kind of
# std::function has two functions for each thing that one holds, or none, where the usual one has eight and a table.
string(CONCAT planish_wasm_flags "-fwasm-exceptions -msimd128 -ffp-contract=off -fno-math-errno"
       " -D_LIBCPP_ABI_OPTIMIZED_FUNCTION -isystem ${planish_wasm}/prefix/include")
set(CMAKE_C_FLAGS_INIT "-fwasm-exceptions -msimd128")
set(CMAKE_CXX_FLAGS_INIT ${planish_wasm_flags})
set(CMAKE_C_FLAGS_RELEASE "-Oz -DNDEBUG" CACHE STRING "")
set(CMAKE_CXX_FLAGS_RELEASE "-Oz -DNDEBUG" CACHE STRING "")
include(${EMSCRIPTEN_ROOT_PATH}/cmake/Modules/Platform/Emscripten.cmake)
list(APPEND CMAKE_FIND_ROOT_PATH ${planish_wasm}/prefix)
list(APPEND CMAKE_PREFIX_PATH ${planish_wasm}/prefix)
set(TBB_DIR ${CMAKE_CURRENT_LIST_DIR}/serial)
