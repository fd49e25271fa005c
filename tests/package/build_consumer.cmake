# What a user of the installed package does; any step that fails fails the test.
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${FOLDER})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${FOLDER}/prefix)
# Every program has its manual.
file(GLOB programs RELATIVE ${FOLDER}/prefix/bin ${FOLDER}/prefix/bin/*)
foreach(program ${programs})
  if(NOT EXISTS ${FOLDER}/prefix/share/man/man1/${program}.1)
    message(FATAL_ERROR "${program} is installed without a manual")
  endif()
endforeach()
set(flags)
if(SANITIZE)
  set(flags -DCMAKE_EXE_LINKER_FLAGS=-fsanitize=${SANITIZE})
endif()
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${FOLDER}/build -G Ninja -DCMAKE_CXX_COMPILER=${COMPILER}
    -DCMAKE_PREFIX_PATH=${FOLDER}/prefix -DEXPECTED_VERSION=${VERSION} ${flags})
run(${CMAKE_COMMAND} --build ${FOLDER}/build)
run(${FOLDER}/build/${PROGRAM} ${ARGUMENTS} WORKING_DIRECTORY ${FOLDER}/build)

# The package can be moved, and does not lean on the tree that it was built in.
file(GLOB_RECURSE files ${FOLDER}/prefix/*.cmake)
foreach(file ${files})
  file(READ ${file} text)
  string(FIND "${text}" "${BUILD}" place)
  if(NOT place EQUAL -1)
    message(FATAL_ERROR "${file} names the build tree")
  endif()
endforeach()
