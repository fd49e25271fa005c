#include <algorithm>

#include "planish/distributed/mesh_part.h"

namespace planish {

namespace {

// Numbers along the curve of the vertices that a slice names, each asked for once.
class NumberTable {
 public:
  NumberTable(const Ranks& ranks, const MeshSlice& slice, const CurveOrder& order) {
    const auto for_all = [&](const auto& take) {
      for (const std::int64_t vertex : slice.face_vertices) take(vertex);
      for (const SliceCrease& crease : slice.creases) {
        take(crease.v0);
        take(crease.v1);
      }
      for (const SliceCorner& corner : slice.corners) take(corner.vertex);
    };
    std::int64_t last = -1;
    std::size_t count = 0;
    first_ = slice.vertex_total();
    for_all([&](std::int64_t vertex) {
      first_ = std::min(first_, vertex);
      last = std::max(last, vertex);
      ++count;
    });
    if (count == 0) first_ = last + 1;
    const auto range = static_cast<std::size_t>(last + 1 - first_);
    // Files usually name near vertices, so that a table over the range is smaller than a list.
    is_dense_ = range <= 2 * count;
    if (is_dense_) {
      numbers_.assign(range, -1);
      for_all([&](std::int64_t vertex) { numbers_[vertex - first_] = 0; });
      for (std::size_t i = 0; i < range; ++i)
        if (numbers_[i] == 0) ids_.push_back(first_ + static_cast<std::int64_t>(i));
    } else {
      ids_.reserve(count);
      for_all([&](std::int64_t vertex) { ids_.push_back(vertex); });
      std::ranges::sort(ids_);
      ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    }
    const auto fetched = fetch<std::int64_t>(
        ranks, ids_, slice.vertices, [&](std::int64_t place) { return order.number_of[place]; });
    if (is_dense_) {
      for (std::size_t i = 0; i < ids_.size(); ++i) numbers_[ids_[i] - first_] = fetched[i];
      ids_ = {};
    } else {
      numbers_.assign(fetched.begin(), fetched.end());
    }
  }

  [[nodiscard]] std::int64_t of(std::int64_t file_id) const {
    if (is_dense_) return numbers_[file_id - first_];
    return numbers_[std::ranges::lower_bound(ids_, file_id) - ids_.begin()];
  }

 private:
  bool is_dense_ = true;
  std::int64_t first_ = 0;
  std::vector<std::int64_t> ids_, numbers_;
};

}  // namespace

FaceStream send_first_ring(const Ranks& ranks, MeshSlice& slice, const CurveOrder& order) {
  {
    const NumberTable numbers(ranks, slice, order);
    for (std::int64_t& vertex : slice.face_vertices) vertex = numbers.of(vertex);
    for (SliceCrease& crease : slice.creases) {
      crease.v0 = numbers.of(crease.v0);
      crease.v1 = numbers.of(crease.v1);
    }
    for (SliceCorner& corner : slice.corners) corner.vertex = numbers.of(corner.vertex);
  }
  const std::int64_t first_face = slice.faces[ranks.rank];
  SliceAttributes& attributes = slice.attributes;
  const FaceForm form(attributes);
  std::vector<int> owners;
  const auto for_owners = [&](std::int64_t face, const auto& take) {
    owners.clear();
    for (const std::int64_t number : slice.face(face))
      owners.push_back(owner_of(order.layout, number));
    std::ranges::sort(owners);
    owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
    for (const int owner : owners) take(owner);
  };
  std::vector<std::int64_t> counts(ranks.size, 0);
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    for_owners(f, [&](int owner) {
      counts[owner] += form.length(static_cast<std::int64_t>(slice.face(f).size()));
    });
  std::vector<std::int64_t> places(counts.size(), 0);
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), std::int64_t{0});
  FaceStream send(static_cast<std::size_t>(places.back() + counts.back()));
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    for_owners(f, [&](int owner) {
      const auto corners = slice.face(f);
      std::int64_t& at = places[owner];
      send[at++] = first_face + f;
      send[at++] = static_cast<std::int64_t>(corners.size());
      at = std::ranges::copy(corners, send.begin() + at).out - send.begin();
      if (form.has_uvs) {
        const auto uvs =
            std::span(attributes.face_uvs).subspan(slice.face_offsets[f], corners.size());
        at = std::ranges::copy(uvs, send.begin() + at).out - send.begin();
      }
      if (form.has_groups) send[at++] = attributes.face_groups[f];
    });
  slice.face_offsets = {0};
  slice.face_vertices = {};
  attributes.face_uvs = {};
  attributes.face_groups = {};
  return all_to_all<std::int64_t>(ranks, send, counts);
}

}  // namespace planish
