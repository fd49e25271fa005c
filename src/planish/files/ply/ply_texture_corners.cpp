#include "planish/files/ply/ply_texture_corners.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "planish/core/formatted.h"

namespace planish {

void PlyTextureCorners::add_face(std::span<const double> numbers, std::size_t corner_count) {
  const bool is_whole =
      numbers.size() == 2 * corner_count &&
      std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
  if (!is_whole && !numbers.empty() && wrong_count_++ == 0) first_wrong_ = face_count_;
  for (std::size_t i = 0; i < corner_count; ++i) {
    values_.push_back(is_whole ? glm::dvec2(numbers[2 * i], numbers[2 * i + 1]) : glm::dvec2(0.0));
    has_.push_back(is_whole ? 1 : 0);
  }
  ++face_count_;
}

void PlyTextureCorners::append(const PlyTextureCorners& behind) {
  if (wrong_count_ == 0 && behind.wrong_count_ > 0)
    first_wrong_ = face_count_ + behind.first_wrong_;
  wrong_count_ += behind.wrong_count_;
  face_count_ += behind.face_count_;
  values_.insert(values_.end(), behind.values_.begin(), behind.values_.end());
  has_.insert(has_.end(), behind.has_.begin(), behind.has_.end());
}

void PlyTextureCorners::finish(MeshFile& file) const {
  if (wrong_count_ > 0)
    file.warnings.push_back(
        {.code = "ignored-texture-coordinates",
         .message = formatted("faces whose list `texcoord` has not two finite numbers for each "
                              "corner, left without texture coordinates: {}",
                              wrong_count_),
         .count = wrong_count_,
         .first = first_wrong_});
  if (std::ranges::find(has_, 1) == has_.end()) return;
  PolygonMesh& mesh = file.mesh;
  std::vector<std::int32_t> corners, lead(has_.size());
  for (std::size_t c = 0; c < has_.size(); ++c)
    if (has_[c] != 0) corners.push_back(static_cast<std::int32_t>(c));
  const auto key_of = [&](std::int32_t c) {
    return std::tuple(mesh.face_vertices[c], values_[c].x, values_[c].y);
  };
  std::ranges::sort(corners, {}, [&](std::int32_t c) { return std::pair(key_of(c), c); });
  // Of those that share one the first corner leads, so that coordinates come in their order.
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const bool is_first = i == 0 || key_of(corners[i]) != key_of(corners[i - 1]);
    lead[corners[i]] = is_first ? corners[i] : lead[corners[i - 1]];
  }
  mesh.uvs.clear();
  mesh.face_uvs.assign(mesh.face_vertices.size(), -1);
  for (std::size_t c = 0; c < has_.size(); ++c) {
    if (has_[c] == 0) continue;
    const bool leads = lead[c] == static_cast<std::int32_t>(c);
    mesh.face_uvs[c] = leads ? static_cast<std::int32_t>(mesh.uvs.size()) : mesh.face_uvs[lead[c]];
    if (leads) mesh.uvs.push_back(values_[c]);
  }
}

}  // namespace planish
