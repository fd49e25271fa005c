#include "planish/patches/patch_mesh.h"

#include "planish/core/assert.h"

namespace planish {

using Around = PatchPlace::Around;

std::int32_t PatchMesh::curve_at_tail(std::int32_t corner) const {
  const std::int32_t edge = topology_.edge_of(corner);
  const std::int32_t end = topology_.corner_of(edge) == corner ? 0 : 1;
  return first_sharp() + 2 * features_.sharp_of_edge[edge] + end;
}

std::int32_t PatchMesh::curve_at_head(std::int32_t corner) const {
  const std::int32_t edge = topology_.edge_of(corner);
  const std::int32_t end = topology_.corner_of(edge) == corner ? 1 : 0;
  return first_sharp() + 2 * features_.sharp_of_edge[edge] + end;
}

std::int32_t PatchMesh::sector_start(std::int32_t corner) const {
  if (features_.sharp_of_edge.empty()) return -1;
  std::int32_t start = corner;
  while (!is_sharp(start)) {
    start = topology_.cw(start);
    if (start == corner) return -1;
  }
  return start;
}

void PatchMesh::sector_starts(std::int32_t vertex, std::vector<std::int32_t>& starts) const {
  starts.clear();
  const auto corners = topology_.corners_at(vertex);
  const VertexKind kind = features_.vertex_kinds[vertex];
  if (kind == VertexKind::Crease || kind == VertexKind::Corner) {
    for (const std::int32_t corner : corners) {
      if (is_sharp(corner)) starts.push_back(corner);
    }
  }
  if (starts.empty()) starts.push_back(corners.front());
}

PatchKind PatchMesh::sector_kind(std::int32_t start) const {
  const std::int32_t vertex = topology_.vertex_of(start);
  if (features_.vertex_kinds[vertex] == VertexKind::Crease) return PatchKind::Crease;
  const std::int32_t sharp = features_.sharp_of_edge[topology_.edge_of(start)];
  switch (features_.corner_sectors.at(SharpFeatures::sector_key(vertex, sharp))) {
    case CornerSector::Convex:
      return PatchKind::Convex;
    case CornerSector::HalfPlane:
      return PatchKind::HalfPlane;
    case CornerSector::Reflex:
      return PatchKind::Reflex;
  }
  return PatchKind::Convex;
}

std::int32_t PatchMesh::sector_size(std::int32_t start) const {
  std::int32_t size = 1;
  for (std::int32_t c = start; !is_sharp(topology_.prev(c)); ++size) c = topology_.ccw(c);
  return size;
}

PatchPlace PatchMesh::corner_patch(std::int32_t corner) const {
  const std::int32_t vertex = topology_.vertex_of(corner);
  const std::int32_t m = topology_.face_size(topology_.face_of(corner));
  const auto n = static_cast<std::int32_t>(topology_.corners_at(vertex).size());
  const VertexKind kind = features_.vertex_kinds[vertex];
  if (kind == VertexKind::Smooth)
    return {{PatchKind::Smooth, n, 0, m}, Around::Vertex, corner, corner};
  const std::int32_t start = sector_start(corner);
  if (start < 0) return {{PatchKind::Cone, n, 0, m}, Around::Vertex, corner, corner};
  if (kind == VertexKind::Dart) {
    const std::int32_t last = topology_.cw(start);
    if (corner != start && corner != last) {
      return {{PatchKind::Smooth, n, 0, m}, Around::Vertex, corner, corner};
    }
    return {{PatchKind::Dart, n, corner == start ? 0 : n - 1, m}, Around::Vertex, corner, start};
  }
  std::int32_t place = 0;
  for (std::int32_t c = start; c != corner; c = topology_.ccw(c)) ++place;
  return {{sector_kind(start), sector_size(start), place, m}, Around::Vertex, corner, start};
}

PatchPlace PatchMesh::vertex_point(std::int32_t start) const {
  const std::int32_t vertex = topology_.vertex_of(start);
  const auto n = static_cast<std::int32_t>(topology_.corners_at(vertex).size());
  const VertexKind kind = features_.vertex_kinds[vertex];
  if (kind == VertexKind::Smooth || kind == VertexKind::Dart) {
    return {{PatchKind::Smooth, n, 0, 0}, Around::Vertex, start, start};
  }
  if (!is_sharp(start)) return {{PatchKind::Cone, n, 0, 0}, Around::Vertex, start, start};
  return {{sector_kind(start), sector_size(start), 0, 0}, Around::Vertex, start, start};
}

PatchPlace PatchMesh::edge_point(std::int32_t corner) const {
  if (is_sharp(corner))
    return {{PatchKind::Crease, 2, 0, 0}, Around::Edge, topology_.next(corner), -1};
  return {{PatchKind::Smooth, 4, 0, 0}, Around::Edge, topology_.next(corner), -1};
}

PatchPlace PatchMesh::face_point(std::int32_t face) const {
  const std::int32_t first = topology_.first_corner(face);
  return {{PatchKind::Smooth, topology_.face_size(face), 0, 0}, Around::Face, first, -1};
}

void PatchMesh::gather(const PatchPlace& place, std::int32_t* indices,
                       std::ptrdiff_t stride) const {
  const auto put = [&](std::int32_t index) {
    *indices = index;
    indices += stride;
  };
  const PatchClass& patch = place.patch;
  const std::int32_t corner = place.corner;
  if (place.around == Around::Face) {
    for (std::int32_t i = 0; i < patch.ring_size; ++i) put(corner + i);
    return;
  }
  if (place.around == Around::Edge) {
    const std::int32_t tail = topology_.prev(corner);
    put(corner);
    put(tail);
    if (patch.kind == PatchKind::Crease) {
      put(curve_at_head(tail));
      put(curve_at_tail(tail));
    } else {
      const std::int32_t other = topology_.twin(tail);
      put(topology_.next(other));
      put(other);
    }
    return;
  }

  put(corner);
  std::int32_t last = corner;  // the ring's last face
  if (patch.kind == PatchKind::Smooth || patch.kind == PatchKind::Cone) {
    const auto around = topology_.corners_at(topology_.vertex_of(corner));
    std::size_t r = 0;
    while (around[r] != corner) ++r;
    for (std::size_t i = r + 1; i < around.size(); ++i) put(around[i]);
    for (std::size_t i = 0; i < r; ++i) put(around[i]);
  } else {
    std::int32_t c = place.sector_start;
    for (std::int32_t i = 0; i < patch.ring_size; ++i) {
      if (c != corner) put(c);
      last = c;
      if (i + 1 < patch.ring_size) c = topology_.ccw(c);
    }
    put(curve_at_tail(place.sector_start));
    if (patch.kind != PatchKind::Dart) put(curve_at_head(topology_.prev(last)));
  }
  if (patch.has_vertex()) {
    put(first_corner_vertex() + features_.corner_of_vertex[topology_.vertex_of(corner)]);
  }
  if (patch.is_limit_only()) return;

  const std::int32_t begin = topology_.first_corner(topology_.face_of(corner));
  const std::int32_t end = begin + patch.face_size;
  for (std::int32_t c = corner + 1; c < end; ++c) put(c);
  for (std::int32_t c = begin; c < corner; ++c) put(c);
  const std::int32_t before = corner > begin ? corner - 1 : end - 1;
  put(patch.is_leading_sharp() ? curve_at_head(corner) : topology_.twin(corner));
  put(patch.is_trailing_sharp() ? curve_at_tail(before) : topology_.next(topology_.twin(before)));
}

}  // namespace planish
