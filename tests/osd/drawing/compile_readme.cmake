# Compiles README's tessellation control shader for every type of patches: -DREADME -DGLSLANG -DINCLUDE
# -DFOLDER.
file(READ ${README} text)
string(FIND "${text}" "```glsl\n#include" start)
if(start LESS 0)
  message(FATAL_ERROR "${README} shows no shader that includes")
endif()
math(EXPR start "${start} + 8")
string(SUBSTRING "${text}" ${start} -1 text)
string(FIND "${text}" "```" end)
string(SUBSTRING "${text}" 0 ${end} text)
file(WRITE ${FOLDER}/readme.tesc
     "#version 450\n#extension GL_GOOGLE_include_directive : require\n${text}")
foreach(type 3 4 5 6 9 10)
  execute_process(COMMAND ${GLSLANG} --target-env vulkan1.1 -DOSD_PATCH_TYPE=${type} -I${INCLUDE} -V
                          -o ${FOLDER}/readme.spv ${FOLDER}/readme.tesc
                  OUTPUT_VARIABLE output RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "type ${type}: ${output}")
  endif()
endforeach()
