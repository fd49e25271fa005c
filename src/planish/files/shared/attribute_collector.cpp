#include "planish/files/shared/attribute_collector.h"

#include <algorithm>

namespace planish {

namespace {

// What a vertex without a colour holds until the end; colours are not negative.
constexpr glm::vec4 kNoColor(-1.0f);
constexpr glm::vec4 kWhite(1.0f);

}  // namespace

void AttributeCollector::use_group(FaceGroup group) {
  group_ = std::move(group);
  group_index_ = -1;
}

std::int32_t AttributeCollector::group_index() {
  if (group_index_ < 0) group_index_ = groups_.index_of(group_);
  return group_index_;
}

void AttributeCollector::add_corner(std::int32_t uv) {
  if (uv >= 0 || !face_uvs_.empty()) {
    face_uvs_.resize(corner_count_, -1);
    face_uvs_.push_back(uv);
  }
  ++corner_count_;
}

void AttributeCollector::add_faces(std::size_t count) {
  if (count == 0) return;
  const bool is_named = !group_.name.empty() || !group_.material.empty();
  if (is_named && face_groups_.empty() && face_count_ > 0) {
    const FaceGroup named = std::exchange(group_, {});
    face_groups_.assign(face_count_, group_index());
    use_group(named);
  }
  if (is_named || !face_groups_.empty()) face_groups_.resize(face_count_ + count, group_index());
  face_count_ += count;
}

bool AttributeCollector::color_vertex(std::int32_t vertex, const glm::vec4& color) {
  const auto slot = static_cast<std::size_t>(vertex);
  if (colors_.size() <= slot) colors_.resize(slot + 1, kNoColor);
  if (colors_[slot] == kNoColor) colors_[slot] = color;
  return colors_[slot] == color;
}

void AttributeCollector::finish(std::vector<glm::dvec2> uvs, PolygonMesh& mesh) {
  if (!face_uvs_.empty()) mesh.uvs = std::move(uvs);
  mesh.face_uvs = std::move(face_uvs_);
  if (!colors_.empty()) {
    colors_.resize(mesh.positions.size(), kNoColor);
    std::replace(colors_.begin(), colors_.end(), kNoColor, kWhite);
    mesh.colors = std::move(colors_);
  }
  mesh.groups = groups_.take();
  mesh.face_groups = std::move(face_groups_);
}

}  // namespace planish
