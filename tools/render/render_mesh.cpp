#include "render_mesh.h"

#include <tiny_gltf.h>

#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"

namespace planish::render {
namespace {

template <class Value>
std::vector<Value> values_of(const tinygltf::Model& model, const tinygltf::Accessor& accessor) {
  const auto& view = model.bufferViews.at(accessor.bufferView);
  const auto& bytes = model.buffers.at(view.buffer).data;
  const std::size_t size = accessor.count * sizeof(Value);
  if (accessor.byteOffset != 0 || view.byteLength < size || view.byteOffset > bytes.size() ||
      bytes.size() - view.byteOffset < size) {
    throw std::out_of_range("accessor");
  }
  std::vector<Value> values(accessor.count);
  std::memcpy(values.data(), bytes.data() + view.byteOffset, size);
  return values;
}

RenderMesh mesh_of(const tinygltf::Model& model) {
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  RenderMesh mesh;
  mesh.positions =
      values_of<glm::vec3>(model, model.accessors.at(primitive.attributes.at("POSITION")));
  mesh.normals = values_of<glm::vec3>(model, model.accessors.at(primitive.attributes.at("NORMAL")));
  const auto& indices = model.accessors.at(primitive.indices);
  if (indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
    const auto narrow = values_of<std::uint16_t>(model, indices);
    mesh.indices.assign(narrow.begin(), narrow.end());
  } else {
    mesh.indices = values_of<std::uint32_t>(model, indices);
  }
  for (const std::uint32_t index : mesh.indices) (void)mesh.positions.at(index);
  if (mesh.normals.size() != mesh.positions.size() || mesh.indices.empty()) {
    throw std::out_of_range("mesh");
  }
  return mesh;
}

}  // namespace

RenderMesh read_glb(const std::filesystem::path& path) {
  const RawVector<std::byte> bytes = read_file(path);
  tinygltf::Model model;
  std::string error, warning;
  const bool read = tinygltf::TinyGLTF().LoadBinaryFromMemory(
      &model, &error, &warning, reinterpret_cast<const unsigned char*>(bytes.data()),
      static_cast<unsigned>(bytes.size()));
  if (!read) throw Error(ErrorCode::UnreadableInput, path.string() + ": " + error);
  try {
    return mesh_of(model);
  } catch (const std::out_of_range&) {
    throw Error(ErrorCode::UnreadableInput,
                path.string() + ": not laid out as planish writes surfaces; run planish fit");
  }
}

std::vector<float> curvature_of(const RenderMesh& mesh) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const glm::vec3& p : mesh.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const float diagonal = glm::distance(low, high);
  std::vector<float> sum(mesh.positions.size()), count(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t a = mesh.indices[i];
    const std::uint32_t b = mesh.indices[i % 3 == 2 ? i - 2 : i + 1];
    const float length = glm::distance(mesh.positions[a], mesh.positions[b]);
    if (length <= 0) continue;
    const float turn = glm::distance(mesh.normals[a], mesh.normals[b]) / length * diagonal;
    for (const std::uint32_t v : {a, b}) {
      sum[v] += turn;
      count[v] += 1;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(count[v], 1.0f);
  return sum;
}

}  // namespace planish::render
