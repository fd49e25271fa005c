#include "planish/surface/shared_points.h"

namespace planish {

// A face has at least three corners: a row for each vertex and midpoint, and one for the centre.
SharedPoints::SharedPoints(const MeshTopology& topology, const PatchNumbering& numbering,
                           std::int64_t corner_count)
    : topology_(topology),
      numbering_(numbering),
      rows_(static_cast<std::size_t>(2 * corner_count + corner_count / 3 + 1)),
      vertices_(static_cast<std::size_t>(corner_count)),
      midpoints_(static_cast<std::size_t>(corner_count)) {}

void SharedPoints::add_face(std::int32_t face) {
  const std::int32_t first = topology_.first_corner(face);
  if (first != end_) begin_ = first;
  end_ = first + topology_.face_size(face);
  centre_ = add(numbering_.face_row(face));
  const std::int32_t begin = begin_;
  const auto is_known = [begin, first](std::int32_t corner) {
    return corner >= begin && corner < first;
  };
  std::int32_t across_trailing = topology_.twin(end_ - 1);
  for (std::int32_t corner = first; corner < end_; ++corner) {
    const std::int32_t across = topology_.twin(corner);
    // Corners at the same vertex: the one across the trailing edge, else that across the leading.
    std::int32_t place = -1;
    if (is_known(across_trailing)) {
      place = vertex(across_trailing);
    } else if (is_known(across)) {
      const std::int32_t other = topology_.next(across);
      place = vertex(other);
    }
    vertices_[corner - begin] = find_or_add(numbering_.vertex_row(corner), place);
    midpoints_[corner - begin] =
        find_or_add(numbering_.edge_row(corner), is_known(across) ? midpoint(across) : -1);
    across_trailing = across;
  }
}

}  // namespace planish
