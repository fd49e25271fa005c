# Installs, compiles the example of the whole way by what pkg-config says, and runs it.
# cmake -DBUILD=... -DFOLDER=... -DEXAMPLE=... -DMESH=... -DCOMPILER=... -DPKG_CONFIG=... -DSHARED=ON|OFF
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${FOLDER})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${FOLDER}/prefix)
file(GLOB_RECURSE pc ${FOLDER}/prefix/*planish.pc)
get_filename_component(pc_folder ${pc} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
set(static)
if(NOT SHARED)
  set(static --static)
endif()
execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${static} planish
                OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags)
execute_process(COMMAND ${PKG_CONFIG} --variable=libdir planish
                OUTPUT_VARIABLE libdir OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
# A C++ compiler, whatever the library needs besides.
run(${COMPILER} -std=c++20 ${EXAMPLE} -o ${FOLDER}/program ${flags} -Wl,-rpath,${libdir})
run(${FOLDER}/program ${MESH} ${FOLDER}/surface.glb)
if(NOT EXISTS ${FOLDER}/surface.glb)
  message(FATAL_ERROR "the program wrote no surface")
endif()
