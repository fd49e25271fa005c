#include "planish/patches/patch_mesh.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/work.h"

namespace planish {
namespace {

// Rings by sums: the rules of subdivision.cpp with sines and cosines of differences written out, a
// derivation of our own. Of a sector of k faces with curve points w0 and w1, Lc their mean, its odd
// part halves the sum of sin(a_j) (x_j - b_j), for
//   c_|i-j| - c_(2k-1-i-j) = delta_ij / 4 + sin(a_i) sin(a_j) / (2k).

constexpr double kPi = std::numbers::pi;

bool is_fan(PatchKind kind) { return kind == PatchKind::Convex || kind == PatchKind::Reflex; }

// Of M, U, W, what a place turns them to.
glm::dvec3 turned(std::int32_t which, double cosine, double sine) {
  return which == 0   ? glm::dvec3(1, 0, 0)
         : which == 1 ? glm::dvec3(1, cosine, sine)
                      : glm::dvec3(1, -sine, cosine);
}

}  // namespace

RingColumns ring_columns(const MeshTopology& topology, Weights weights,
                         std::span<const std::int32_t> vertices) {
  if (weights == Weights::DooSabin) return RingColumns::Sums;
  const auto refuse = [](const std::string& what, std::int32_t number, std::int32_t size,
                         const char* parts) {
    throw Error(
        ErrorCode::UnusableMesh,
        formatted("{} {} has {} {}, averaged weights take {} at most; doo-sabin weights take more",
                  what, number, size, parts, kLargestByPoints),
        number);
  };
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    const auto size = static_cast<std::int32_t>(topology.corners_at(v).size());
    if (size > kLargestByPoints)
      refuse("vertex", vertices.empty() ? v : vertices[v], size, "faces");
  }
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    if (topology.face_size(f) > kLargestByPoints)
      refuse("face", f, topology.face_size(f), "corners");
  return RingColumns::Points;
}

RingAngles ring_angles(PatchKind kind, std::int32_t size) {
  if (kind == PatchKind::Smooth || kind == PatchKind::Cone || kind == PatchKind::Dart)
    return {0, 2 * kPi / size};
  const double opening = kind == PatchKind::Convex   ? 0.5 * kPi
                         : kind == PatchKind::Reflex ? 1.5 * kPi
                                                     : kPi;
  return {opening / (2 * size), opening / size};
}

std::vector<glm::dvec3> ring_weights(const LargeRing& ring) {
  const auto size = static_cast<std::size_t>(ring.size);
  const auto [first, step] = ring_angles(ring.kind, ring.size);
  const double share = 1.0 / ring.size;
  std::vector<glm::dvec3> rows(size, glm::dvec3(0.0));
  if (is_fan(ring.kind)) {
    const double sign = ring.kind == PatchKind::Reflex ? -1 : 1, root = std::numbers::sqrt2;
    rows.insert(rows.end(), {{0, root, 0}, {0, 0, sign * root}, {1, -root, -sign * root}});
    return rows;
  }
  double sines = 0;
  for (std::size_t j = 0; j < size; ++j) {
    const double angle = first + step * static_cast<double>(j);
    rows[j].z = 2 * share * portable::sin(angle);
    sines += rows[j].z;
    if (!ring.is_sector()) rows[j] = {share, 2 * share * portable::cos(angle), rows[j].z};
  }
  if (!ring.is_sector()) return rows;
  // The curve's own shares in b_j have no sine sum.
  rows.emplace_back(0.5, 1 / std::numbers::sqrt2, -sines / 2);
  rows.emplace_back(0.5, -1 / std::numbers::sqrt2, -sines / 2);
  if (ring.kind == PatchKind::HalfPlane) rows.emplace_back(0, 0, 0);
  return rows;
}

void write_ring_sums(const LargeRing& ring, std::span<const glm::dvec3> points, glm::dvec3* sums) {
  const std::vector<glm::dvec3> rows = ring_weights(ring);
  PLANISH_ASSERT(rows.size() == points.size());
  // About one of the points: far from the origin sums would lose digits.
  const glm::dvec3 origin = points.front();
  glm::dvec3 mean(0.0), even(0.0), odd(0.0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const glm::dvec3 p = points[i] - origin;
    mean += rows[i].x * p;
    even += rows[i].y * p;
    odd += rows[i].z * p;
  }
  const auto [first, step] = ring_angles(ring.kind, ring.size);
  for (std::int32_t i = 0; i < ring.size; ++i) {
    const double c = portable::cos(first + step * i), s = portable::sin(first + step * i);
    for (std::int32_t which = 0; which < 3; ++which) {
      const glm::dvec3 share = turned(which, c, s);
      *sums++ = origin + (mean + (share.y * even + share.z * odd));
    }
  }
}

std::vector<double> sum_weights(const LargeRing& ring, std::int32_t sum) {
  const auto [first, step] = ring_angles(ring.kind, ring.size);
  const double angle = first + step * (sum / 3);
  const glm::dvec3 share = turned(sum % 3, portable::cos(angle), portable::sin(angle));
  std::vector<double> result;
  for (const glm::dvec3& row : ring_weights(ring))
    result.push_back(row.x + share.y * row.y + share.z * row.z);
  return result;
}

using Around = PatchPlace::Around;

PatchMesh::PatchMesh(const MeshTopology& topology, const SharpFeatures& features,
                     RingColumns columns)
    : topology_(topology), features_(features) {
  if (columns == RingColumns::Sums) find_large_rings();
}

void PatchMesh::find_large_rings() {
  std::vector<std::int32_t> starts;
  for (std::int32_t v = 0; v < topology_.vertex_count(); ++v) {
    const auto corners = topology_.corners_at(v);
    const auto n = static_cast<std::int32_t>(corners.size());
    if (n < kSummedRing) continue;
    const VertexKind kind = features_.vertex_kinds[v];
    sector_starts(v, starts);
    if (kind == VertexKind::Smooth) {
      add_ring(PatchKind::Smooth, starts.front(), n, false);
    } else if (kind == VertexKind::Dart) {
      add_ring(PatchKind::Dart, sector_start(starts.front()), n, false);
    } else if (!is_sharp(starts.front())) {
      add_ring(PatchKind::Cone, starts.front(), n, false);
    } else {
      for (const std::int32_t start : starts) {
        const std::int32_t size = sector_size(start);
        if (size >= kSummedRing) add_ring(sector_kind(start), start, size, false);
      }
    }
  }
  vertex_ring_count_ = rings_.size();
  for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
    const std::int32_t size = topology_.face_size(f);
    if (size >= kSummedRing) add_ring(PatchKind::Smooth, topology_.first_corner(f), size, true);
  }
  std::int64_t count = 0;
  for (LargeRing& ring : rings_) {
    ring.first_sum = static_cast<std::int32_t>(state_size() + count);
    count += ring.sum_count();
    if (state_size() + count <= std::numeric_limits<std::int32_t>::max()) continue;
    // More than indices reach: by points, as ever.
    rings_.clear();
    ring_of_corner_.clear();
    return;
  }
  sum_count_ = static_cast<std::int32_t>(count);
}

void PatchMesh::add_ring(PatchKind kind, std::int32_t start, std::int32_t size, bool is_face) {
  const auto index = static_cast<std::int32_t>(rings_.size());
  rings_.push_back({kind, start, size, 0});
  if (is_face) return;
  if (ring_of_corner_.empty()) {
    ring_of_corner_.assign(static_cast<std::size_t>(topology_.corner_count()), -1);
    place_of_corner_.resize(ring_of_corner_.size());
  }
  std::int32_t c = start;
  for (std::int32_t i = 0; i < size; ++i) {
    ring_of_corner_[c] = index;
    place_of_corner_[c] = i;
    if (i + 1 < size) c = topology_.ccw(c);
  }
}

PatchMesh::PlaceInRing PatchMesh::ring_of_face(std::int32_t corner) const {
  if (vertex_ring_count_ == rings_.size()) return {};
  const std::int32_t first = topology_.first_corner(topology_.face_of(corner));
  const auto rings = std::span(rings_).subspan(vertex_ring_count_);
  const auto found = std::ranges::lower_bound(rings, first, {}, &LargeRing::start);
  if (found == rings.end() || found->start != first) return {};
  return {&*found, corner - first};
}

const LargeRing& PatchMesh::ring_of_sum(std::int32_t point) const {
  PLANISH_ASSERT(point >= state_size() && point < point_count());
  return *(std::ranges::upper_bound(rings_, point, {}, &LargeRing::first_sum) - 1);
}

void PatchMesh::ring_points(const LargeRing& ring, std::vector<std::int32_t>& points) const {
  points.clear();
  const bool is_face = is_face_ring(ring);
  std::int32_t c = ring.start, last = c;
  for (std::int32_t i = 0; i < ring.size; ++i) {
    points.push_back(c);
    last = c;
    if (i + 1 < ring.size) c = is_face ? c + 1 : topology_.ccw(c);
  }
  if (!ring.is_sector()) return;
  points.push_back(curve_at_tail(ring.start));
  points.push_back(curve_at_head(topology_.prev(last)));
  if (ring.kind != PatchKind::Crease)
    points.push_back(first_corner_vertex() +
                     features_.corner_of_vertex[topology_.vertex_of(ring.start)]);
}

RawVector<glm::dvec3> PatchMesh::with_sums(std::span<const glm::dvec3> state) const {
  RawVector<glm::dvec3> points(static_cast<std::size_t>(point_count()));
  std::ranges::copy(state, points.begin());
  update_sums(points);
  return points;
}

void PatchMesh::update_ring(const LargeRing& ring, std::span<glm::dvec3> points) const {
  std::vector<std::int32_t> indices;
  ring_points(ring, indices);
  count_work(Work::Products, 3 * std::ssize(indices));
  std::vector<glm::dvec3> of_ring;
  of_ring.reserve(indices.size());
  for (const std::int32_t i : indices) of_ring.push_back(points[i]);
  write_ring_sums(ring, of_ring, points.data() + ring.first_sum);
}

void PatchMesh::update_sums(std::span<glm::dvec3> points) const {
  parallel_each(rings_.size(), 1, [&](std::size_t r) { update_ring(rings_[r], points); });
}

void PatchMesh::update_sums_at(std::span<const std::int32_t> corners,
                               std::span<glm::dvec3> points) const {
  if (!has_sums()) return;
  std::vector<const LargeRing*> rings;
  for (const std::int32_t corner : corners) {
    for (const LargeRing* ring : {ring_around_vertex(corner).ring, ring_of_face(corner).ring})
      if (ring != nullptr) rings.push_back(ring);
  }
  std::ranges::sort(rings);
  rings.erase(std::ranges::unique(rings).begin(), rings.end());
  for (const LargeRing* ring : rings) update_ring(*ring, points);
}

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
  if (const LargeRing* ring = ring_around_vertex(corner).ring; ring != nullptr)
    return is_sharp(ring->start) ? ring->start : -1;
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

std::int32_t PatchMesh::sector_corner(std::int32_t corner) const {
  const std::int32_t vertex = topology_.vertex_of(corner);
  const VertexKind kind = features_.vertex_kinds[vertex];
  const bool has_sectors = kind == VertexKind::Crease || kind == VertexKind::Corner;
  const std::int32_t start = has_sectors ? sector_start(corner) : -1;
  return start >= 0 ? start : topology_.corners_at(vertex).front();
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

// A corner patch's without the face.
PatchClass PatchMesh::by_sums(const PlaceInRing& at) {
  const LargeRing& ring = *at.ring;
  PatchClass patch{ring.kind, ring.size};
  patch.has_ring_sums = true;
  const bool is_end = at.place == 0 || at.place == ring.size - 1;
  if (ring.kind == PatchKind::Dart && !is_end) patch.kind = PatchKind::Smooth;
  if (patch.has_sharp_edges()) patch.place = is_end ? at.place : 1;
  return patch;
}

PatchPlace PatchMesh::corner_patch(std::int32_t corner) const {
  PatchPlace place = around_vertex(corner);
  place.patch.face_size = topology_.face_size(topology_.face_of(corner));
  place.patch.has_face_sums = ring_of_face(corner).ring != nullptr;
  return place;
}

PatchPlace PatchMesh::around_vertex(std::int32_t corner) const {
  if (const PlaceInRing at = ring_around_vertex(corner); at.ring != nullptr)
    return {by_sums(at), Around::Vertex, corner, at.ring->start};
  const std::int32_t vertex = topology_.vertex_of(corner);
  const auto n = static_cast<std::int32_t>(topology_.corners_at(vertex).size());
  const VertexKind kind = features_.vertex_kinds[vertex];
  if (kind == VertexKind::Smooth) return {{PatchKind::Smooth, n}, Around::Vertex, corner, corner};
  const std::int32_t start = sector_start(corner);
  if (start < 0) return {{PatchKind::Cone, n}, Around::Vertex, corner, corner};
  if (kind == VertexKind::Dart) {
    const std::int32_t last = topology_.cw(start);
    if (corner != start && corner != last) {
      return {{PatchKind::Smooth, n}, Around::Vertex, corner, corner};
    }
    return {{PatchKind::Dart, n, corner == start ? 0 : n - 1}, Around::Vertex, corner, start};
  }
  std::int32_t place = 0;
  for (std::int32_t c = start; c != corner; c = topology_.ccw(c)) ++place;
  return {{sector_kind(start), sector_size(start), place}, Around::Vertex, corner, start};
}

PatchPlace PatchMesh::vertex_point(std::int32_t start) const {
  PatchPlace place = around_vertex(start);
  // A dart's limit point is that of its whole ring.
  if (place.patch.kind == PatchKind::Dart)
    place.patch.kind = PatchKind::Smooth, place.patch.place = 0;
  return place;
}

PatchPlace PatchMesh::edge_point(std::int32_t corner) const {
  if (is_sharp(corner))
    return {{PatchKind::Crease, 2, 0, 0}, Around::Edge, topology_.next(corner), -1};
  return {{PatchKind::Smooth, 4, 0, 0}, Around::Edge, topology_.next(corner), -1};
}

PatchPlace PatchMesh::face_point(std::int32_t face) const {
  const std::int32_t first = topology_.first_corner(face);
  PatchClass patch{PatchKind::Smooth, topology_.face_size(face)};
  patch.has_ring_sums = ring_of_face(first).ring != nullptr;
  return {patch, Around::Face, first, -1};
}

void PatchMesh::gather(const PatchPlace& place, std::int32_t* indices,
                       std::ptrdiff_t stride) const {
  const auto put = [&](std::int32_t index) {
    *indices = index;
    indices += stride;
  };
  const PatchClass& patch = place.patch;
  const std::int32_t corner = place.corner;
  const auto put_sums = [&](const PlaceInRing& at) {
    for (std::int32_t i = 0; i < 3; ++i) put(at.first_sum() + i);
  };
  if (place.around == Around::Face) {
    if (patch.has_ring_sums) {
      for (const std::int32_t i : {0, 1, patch.ring_size - 1}) put(corner + i);
      put_sums(ring_of_face(corner));
      return;
    }
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
  if (patch.has_ring_sums) {
    // Beyond a sharp edge nothing is asked for.
    put(patch.is_trailing_sharp() && patch.kind != PatchKind::Dart ? corner
                                                                   : topology_.ccw(corner));
    put(patch.is_leading_sharp() && patch.kind != PatchKind::Dart ? corner : topology_.cw(corner));
    put_sums(ring_around_vertex(corner));
    if (patch.is_leading_sharp() || patch.kind == PatchKind::Dart)
      put(curve_at_tail(place.sector_start));
    else if (patch.is_trailing_sharp())
      put(curve_at_head(topology_.prev(corner)));
  } else if (patch.kind == PatchKind::Smooth || patch.kind == PatchKind::Cone) {
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
  const std::int32_t before = corner > begin ? corner - 1 : end - 1;
  if (patch.has_face_sums) {
    put(corner + 1 < end ? corner + 1 : begin);
    put(before);
    put_sums(ring_of_face(corner));
  } else {
    for (std::int32_t c = corner + 1; c < end; ++c) put(c);
    for (std::int32_t c = begin; c < corner; ++c) put(c);
  }
  put(patch.is_leading_sharp() ? curve_at_head(corner) : topology_.twin(corner));
  put(patch.is_trailing_sharp() ? curve_at_tail(before) : topology_.next(topology_.twin(before)));
}

}  // namespace planish
