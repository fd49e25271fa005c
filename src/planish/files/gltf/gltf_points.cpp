#include "planish/files/gltf/gltf_points.h"

#include <cstddef>
#include <utility>

namespace planish {
namespace {

constexpr glm::vec3 kNoPointNormal(0.0f);
constexpr glm::vec4 kPlainWhite(1.0f);

}  // namespace

void GltfPoints::add(const SourcePrimitive& primitive, const GltfInstance& instance) {
  const std::size_t before = positions_.size();
  const std::int64_t count = primitive.positions().count();
  for (std::int64_t i = 0; i < count; ++i) positions_.push_back(primitive.position(i, instance));
  if (const auto normals = primitive.attribute("NORMAL", GltfAccessor::Use::Normals)) {
    normals_.resize(before, kNoPointNormal);
    for (std::int64_t i = 0; i < count; ++i)
      normals_.emplace_back(placed_normal(normals->position(i), instance));
  }
  if (const auto colors = primitive.attribute("COLOR_0", GltfAccessor::Use::Colors)) {
    colors_.resize(before, kPlainWhite);
    for (std::int64_t i = 0; i < count; ++i) colors_.push_back(primitive.color(*colors, i));
  }
}

void GltfPoints::finish(MeshFile& file) {
  if (!normals_.empty()) normals_.resize(positions_.size(), kNoPointNormal);
  if (!colors_.empty()) colors_.resize(positions_.size(), kPlainWhite);
  file.mesh.positions = std::move(positions_);
  file.normals = std::move(normals_);
  file.mesh.colors = std::move(colors_);
}

}  // namespace planish
