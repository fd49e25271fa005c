#include "render_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "planish/core/json.h"
#include "planish/files/gltf/glb_parts.h"
#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/read_file.h"

namespace planish::render {
namespace {

// Appends a primitive of triangles.
void add_primitive(const JsonPlace& root, const JsonPlace& primitive, GltfSource& source,
                   const std::string& attribute, RenderMesh& mesh) {
  const auto accessor = [&](const JsonPlace& place, GltfAccessor::Use use) {
    return GltfAccessor(root, place.integer(), use, source);
  };
  const JsonPlace attributes = primitive["attributes"];
  const GltfAccessor positions = accessor(attributes["POSITION"], GltfAccessor::Use::Positions);
  // Vectors of three as well.
  const GltfAccessor normals = accessor(attributes["NORMAL"], GltfAccessor::Use::Positions);
  const GltfAccessor indices = accessor(primitive["indices"], GltfAccessor::Use::Indices);
  if (normals.count() != positions.count())
    attributes["NORMAL"].fail(std::to_string(normals.count()) + " normals for " +
                              std::to_string(positions.count()) + " vertices");
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::int64_t i = 0; i < positions.count(); ++i) {
    mesh.positions.emplace_back(positions.position(i));
    mesh.normals.push_back(glm::normalize(glm::vec3(normals.position(i))));
  }
  if (!attribute.empty()) {
    const GltfAccessor values = accessor(attributes[attribute], GltfAccessor::Use::Numbers);
    if (values.count() != positions.count())
      attributes[attribute].fail(std::to_string(values.count()) + " numbers for " +
                                 std::to_string(positions.count()) + " vertices");
    for (std::int64_t i = 0; i < values.count(); ++i)
      mesh.values.push_back(static_cast<float>(values.value(i)));
  }
  for (std::int64_t i = 0; i < indices.count(); ++i) {
    if (indices.index(i) >= positions.count())
      primitive["indices"].fail("entry " + std::to_string(i) + " names no vertex");
    mesh.indices.push_back(first + indices.index(i));
  }
}

}  // namespace

RenderMesh read_glb(const std::filesystem::path& path, const std::string& attribute) {
  const RawVector<std::byte> bytes = read_file(path);
  const std::string name = path.string();
  const GlbParts parts = split_glb(bytes, name);
  const nlohmann::json document = parse_json(parts.json, name);
  const JsonPlace root(document, name, "");
  GltfSource source(root, parts.chunk, std::nullopt);
  RenderMesh mesh;
  const JsonPlace primitives = root["meshes"][0]["primitives"];
  for (std::int64_t i = 0; i < primitives.array_size(); ++i)
    add_primitive(root, primitives[i], source, attribute, mesh);
  if (mesh.indices.empty()) primitives.fail("holds no triangles");
  return mesh;
}

float usual_magnitude(const std::vector<float>& values) {
  std::vector<float> sizes;
  for (const float value : values)
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  if (sizes.empty()) return 1;
  const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 19 / 20);
  std::nth_element(sizes.begin(), place, sizes.end());
  return *place > 0 ? *place : 1;
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
