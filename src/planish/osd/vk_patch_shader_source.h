#pragma once

#include <opensubdiv/far/patchDescriptor.h>

#include <string>

namespace planish::osd {

/// What Osd::GLSLPatchShaderSource is for OpenGL: functions in GLSL to draw a VkPatchTable's
/// patches with. The same text lies in planish_SHADER_DIR as planish_osd_patches.glsl and
/// planish_osd_tessellation.glsl, for compilers that include; their heads say how they are used.
class VkPatchShaderSource {
 public:
  /// To be put between `#version` and the shader's own text. Empty for types that are not drawn:
  /// points, lines and legacy Gregory patches.
  static std::string GetPatchDrawingShaderSource(OpenSubdiv::Far::PatchDescriptor::Type type);
};

}  // namespace planish::osd
