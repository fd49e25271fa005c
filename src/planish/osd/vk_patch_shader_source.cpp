#include "planish/osd/vk_patch_shader_source.h"

#include "shaders/osd_patches_text.h"

namespace planish::osd {

using OpenSubdiv::Far::PatchDescriptor;

std::string VkPatchShaderSource::GetPatchDrawingShaderSource(PatchDescriptor::Type type) {
  switch (type) {
    case PatchDescriptor::QUADS:
    case PatchDescriptor::TRIANGLES:
    case PatchDescriptor::LOOP:
    case PatchDescriptor::REGULAR:
    case PatchDescriptor::GREGORY_BASIS:
    case PatchDescriptor::GREGORY_TRIANGLE:
      return "#define OSD_PATCH_TYPE " + std::to_string(type) + "\n" + kPatchesText +
             kTessellationText;
    default:
      return {};
  }
}

}  // namespace planish::osd
