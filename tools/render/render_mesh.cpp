#include "render_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <string_view>
#include <utility>

#include "planish/core/json.h"
#include "planish/core/point_bounds.h"
#include "planish/files/gltf/glb_parts.h"
#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/gltf/gltf_budget.h"
#include "planish/files/gltf/gltf_nodes.h"
#include "planish/files/read_file.h"

namespace planish::render {
namespace {

// Turns normals as the surface turns: by cofactors, which need no inverse.
glm::dmat3 normals_transform(const glm::dmat3& m) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                             glm::cross(m[0], m[1]));
  return glm::determinant(m) < 0 ? -cofactors : cofactors;
}

class SceneDrawing {
 public:
  SceneDrawing(const JsonPlace& root, GltfSource& source, std::string_view file,
               const std::string& attribute)
      : root_(root), source_(source), budget_({}, file), attribute_(attribute) {}

  RenderMesh read() {
    const std::vector<GltfInstance> instances = gltf_scene(root_, source_).instances;
    if (!instances.empty()) mesh_.origin = instances.front().to_world[3];
    for (const GltfInstance& instance : instances) {
      const JsonPlace primitives = root_["meshes"][instance.mesh]["primitives"];
      for (std::int64_t i = 0; i < primitives.array_size(); ++i)
        add_primitive(primitives[i], instance.to_world);
    }
    if (mesh_.indices.empty()) root_.fail("its default scene places no triangles");
    return std::move(mesh_);
  }

 private:
  void add_primitive(const JsonPlace& primitive, const glm::dmat4& to_world);

  const JsonPlace& root_;
  GltfSource& source_;
  GltfBudget budget_;
  const std::string& attribute_;
  RenderMesh mesh_;
};

// Appends triangles.
void SceneDrawing::add_primitive(const JsonPlace& primitive, const glm::dmat4& to_world) {
  const auto accessor = [&](const JsonPlace& place, GltfAccessor::Use use) {
    return GltfAccessor(root_, place.integer(), use, source_);
  };
  const JsonPlace attributes = primitive["attributes"];
  const GltfAccessor positions = accessor(attributes["POSITION"], GltfAccessor::Use::Positions);
  // Vectors of three as well.
  const GltfAccessor normals = accessor(attributes["NORMAL"], GltfAccessor::Use::Positions);
  const GltfAccessor indices = accessor(primitive["indices"], GltfAccessor::Use::Indices);
  if (normals.count() != positions.count())
    attributes["NORMAL"].fail("{} normals for {} vertices", normals.count(), positions.count());
  budget_.add_triangles(primitive, positions.count(), indices.count());
  const glm::dmat3 linear(to_world), turned = normals_transform(linear);
  const glm::dvec3 shift = glm::dvec3(to_world[3]) - mesh_.origin;
  const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
  for (std::int64_t i = 0; i < positions.count(); ++i) {
    mesh_.positions.emplace_back(linear * positions.position(i) + shift);
    mesh_.normals.push_back(glm::normalize(glm::vec3(turned * normals.position(i))));
  }
  if (!attribute_.empty()) {
    const GltfAccessor values = accessor(attributes[attribute_], GltfAccessor::Use::Numbers);
    if (values.count() != positions.count())
      attributes[attribute_].fail("{} numbers for {} vertices", values.count(), positions.count());
    for (std::int64_t i = 0; i < values.count(); ++i)
      mesh_.values.push_back(static_cast<float>(values.value(i)));
  }
  for (std::int64_t i = 0; i < indices.count(); ++i) {
    if (indices.index(i) >= positions.count())
      primitive["indices"].fail("entry {} names no vertex", i);
    mesh_.indices.push_back(first + indices.index(i));
  }
}

}  // namespace

RenderMesh read_glb(const std::filesystem::path& path, const std::string& attribute) {
  const RawVector<std::byte> bytes = read_file(path);
  const std::string name = path.string();
  const GlbParts parts = split_glb(bytes, name);
  const nlohmann::json document = parse_json(parts.json, name);
  const JsonPlace root(document, name, "");
  GltfSource source(root, parts.chunk, FileBytes{});
  return SceneDrawing(root, source, name, attribute).read();
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
  const auto [low, high] = point_bounds(mesh.positions);
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
