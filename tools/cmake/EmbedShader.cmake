# planish_embed_shader(SOURCE <glsl> OUTPUT <path> NAME <array> NAMESPACE <namespace>
#                      [FLAGS <of glslangValidator>...] [DEPENDS <generated include>...])
# Compiles a shader to OUTPUT.spv, has spirv-val check it, and writes the header OUTPUT.spv.h with
# its words as NAMESPACE::NAME. Two commands: the depfile names the .spv only.
function(planish_embed_shader)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "SOURCE;OUTPUT;NAME;NAMESPACE" "FLAGS;DEPENDS")
  set(embed ${PROJECT_SOURCE_DIR}/tools/cmake/EmbedSpirv.cmake)
  get_filename_component(folder ${arg_OUTPUT} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  add_custom_command(
    OUTPUT ${arg_OUTPUT}.spv
    COMMAND ${PLANISH_GLSLANG} --target-env vulkan1.1 ${arg_FLAGS} -V --depfile ${arg_OUTPUT}.d
            -o ${arg_OUTPUT}.spv ${arg_SOURCE}
    COMMAND ${PLANISH_SPIRV_VAL} --target-env vulkan1.1 ${arg_OUTPUT}.spv
    DEPENDS ${arg_SOURCE} ${arg_DEPENDS} DEPFILE ${arg_OUTPUT}.d
    COMMENT "Compiling ${arg_NAME}" VERBATIM)
  add_custom_command(
    OUTPUT ${arg_OUTPUT}.spv.h
    COMMAND ${CMAKE_COMMAND} -DINPUT=${arg_OUTPUT}.spv -DOUTPUT=${arg_OUTPUT}.spv.h -DNAME=${arg_NAME}
            -DNAMESPACE=${arg_NAMESPACE} -P ${embed}
    DEPENDS ${arg_OUTPUT}.spv ${embed} VERBATIM)
endfunction()
