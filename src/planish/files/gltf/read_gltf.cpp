// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.7 (meshes) and 4 (GLB).
#include "planish/files/gltf/read_gltf.h"

#include "planish/core/json.h"
#include "planish/files/gltf/glb_parts.h"
#include "planish/files/gltf/scene_reader.h"

namespace planish {

MeshFile read_gltf(const FileBytes& file) { return read_gltf_within(file, {}); }

MeshFile read_gltf_within(const FileBytes& file, const GltfLimits& limits) {
  const GlbParts parts = split_glb(file.bytes, file.name);
  const nlohmann::json document = parse_json(parts.json, file.name);
  const JsonPlace root(document, file.name, "");
  require_gltf_version(root);
  GltfSource source(root, parts.chunk, file);
  return SceneReader(root, source, GltfBudget(limits, file.name), file).read(parts.format);
}

}  // namespace planish
