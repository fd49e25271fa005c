#include "planish/surface/level_one_uvs.h"

#include <algorithm>
#include <glm/common.hpp>

#include "planish/doosabin/vertex_ring.h"

namespace planish {

namespace {

// Where the edge between two control points crosses the edge of Q_1 from a vertex to the middle of
// the mesh's edge.
constexpr double kCrossing = 0.25;

// Seen from a face of a ring, the neighbour on the edge to the ring's next face.
NetCorner::Toward toward_next_face(RingAround around) {
  return around == RingAround::Vertex ? NetCorner::Toward::Previous : NetCorner::Toward::Next;
}
NetCorner::Toward toward_previous_face(RingAround around) {
  return around == RingAround::Vertex ? NetCorner::Toward::Next : NetCorner::Toward::Previous;
}

// Moves the far ones, or where there are none all but `count` from `first` on, until the mean is
// the one wanted.
void keep_mean(std::span<glm::dvec2> values, const std::vector<bool>& is_far,
               const glm::dvec2& mean, std::size_t first, std::size_t count) {
  const std::size_t n = values.size();
  const auto far_count = static_cast<std::size_t>(std::ranges::count(is_far, true));
  glm::dvec2 move = static_cast<double>(n) * mean;
  for (const glm::dvec2& value : values) move -= value;
  move /= static_cast<double>(far_count > 0 ? far_count : n - count);
  for (std::size_t i = 0; i < n; ++i) {
    const bool moves = far_count > 0 ? is_far[i] : (i + n - first) % n >= count;
    if (moves) values[i] += move;
  }
}

}  // namespace

LevelOneUvs::LevelOneUvs(const SubdividedMesh& base) : base_(base), mesh_(base.used.mesh) {
  if (mesh_.face_uvs.empty()) return;
  for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
    const auto uvs = std::span(mesh_.face_uvs)
                         .subspan(static_cast<std::size_t>(mesh_.face_offsets[f]),
                                  static_cast<std::size_t>(mesh_.face_size(f)));
    has_uvs_.push_back(std::ranges::min(uvs) >= 0);
    mesh_face_.insert(mesh_face_.end(), uvs.size(), f);
  }
  const auto corner_count = static_cast<std::int32_t>(mesh_face_.size());
  for (std::int32_t c = 0; c < corner_count; ++c) {
    uvs_.push_back(has_uvs_[mesh_face_[c]] ? mean_over(c) : glm::dvec2(0.0));
  }
  interpolate_given();
}

std::int32_t LevelOneUvs::neighbour(std::int32_t corner, NetCorner::Toward toward) const {
  const std::int32_t first = mesh_.face_offsets[mesh_face_[corner]];
  const std::int32_t last = mesh_.face_offsets[mesh_face_[corner] + 1] - 1;
  if (toward == NetCorner::Toward::Next) return corner == last ? first : corner + 1;
  return corner == first ? last : corner - 1;
}

glm::dvec2 LevelOneUvs::given(std::int32_t corner) const {
  return mesh_.uvs[mesh_.face_uvs[corner]];
}

// The mean of the four corners of a face of Q_1.
glm::dvec2 LevelOneUvs::mean_over(std::int32_t corner) const {
  const std::int32_t face = mesh_face_[corner];
  glm::dvec2 centre(0.0);
  for (std::int32_t c = mesh_.face_offsets[face]; c < mesh_.face_offsets[face + 1]; ++c) {
    centre += given(c) / static_cast<double>(mesh_.face_size(face));
  }
  return 0.25 * centre + 0.5 * given(corner) +
         0.125 * given(neighbour(corner, NetCorner::Toward::Next)) +
         0.125 * given(neighbour(corner, NetCorner::Toward::Previous));
}

void LevelOneUvs::interpolate_given() {
  VertexRing ring;
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
    gather_ring(base_.subdivision, v, ring);
    const std::size_t n = ring.faces.size();
    if (ring.kind != VertexKind::Smooth) continue;
    bool whole = true;
    glm::dvec2 mean(0.0);
    for (std::size_t i = 0; i < n; ++i) {
      const NetCorner corner{ring.faces[i], ring.faces[i]};
      const std::int32_t next = ring.faces[(i + 1) % n];
      whole = whole && has_uvs_[mesh_face_[corner.face]] && has_uvs_[mesh_face_[next]] &&
              !is_seam(corner, {next, next}, RingAround::Vertex);
      mean += uvs_[corner.face] / static_cast<double>(n);
    }
    if (!whole) continue;
    const glm::dvec2 move = given(ring.faces.front()) - mean;
    for (const std::int32_t face : ring.faces) uvs_[face] += move;
  }
}

glm::dvec2 LevelOneUvs::value(const NetCorner& corner) const {
  if (corner.along < 0) return uvs_[corner.face];
  return glm::mix(given(corner.face), given(neighbour(corner.face, corner.toward)), corner.along);
}

bool LevelOneUvs::is_seam(const NetCorner& from, const NetCorner& to, RingAround around) const {
  if (mesh_face_[from.face] == mesh_face_[to.face]) return false;
  return given(from.face) != given(to.face) ||
         given(neighbour(from.face, toward_next_face(around))) !=
             given(neighbour(to.face, toward_previous_face(around)));
}

std::int32_t LevelOneUvs::index_of(const NetCorner& corner) {
  if (corner.along < 0) return corner.face;
  const auto [place, is_new] = index_on_edge_.try_emplace({corner.vertex, corner.face});
  if (is_new) {
    place->second = static_cast<std::int32_t>(uvs_.size());
    uvs_.push_back(value(corner));
  }
  return place->second;
}

void LevelOneUvs::add(std::span<const NetCorner> polygon, RingAround around, bool closed) {
  if (mesh_.face_uvs.empty()) return;
  const std::size_t n = polygon.size();
  if (std::ranges::any_of(polygon,
                          [&](const NetCorner& c) { return !has_uvs_[mesh_face_[c.face]]; })) {
    face_uvs_.insert(face_uvs_.end(), n, -1);
    return;
  }
  // Corners that begin a chart; an open polygon's first always does.
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < n; ++i) {
    const NetCorner& previous = polygon[(i + n - 1) % n];
    const bool compared = i > 0 || closed;
    if (!compared || is_seam(previous, polygon[i], around)) begins.push_back(i);
  }
  if (begins.size() < 2) {
    for (const NetCorner& corner : polygon) face_uvs_.push_back(index_of(corner));
    return;
  }
  Chart largest{0, 0};
  for (std::size_t k = 0; k < begins.size(); ++k) {
    const std::size_t end = k + 1 < begins.size() ? begins[k + 1] : begins[0] + n;
    if (end - begins[k] > largest.count) largest = {begins[k], end - begins[k]};
  }
  add_continued(polygon, largest, around, closed);
}

void LevelOneUvs::add_continued(std::span<const NetCorner> polygon, Chart chart, RingAround around,
                                bool closed) {
  const std::size_t n = polygon.size();
  const std::size_t first = chart.first, last = (chart.first + chart.count - 1) % n;
  const std::size_t before = (first + n - 1) % n, after = (last + 1) % n;
  const auto seen = [&](std::size_t i, double along, NetCorner::Toward toward) {
    return value({polygon[i].vertex, polygon[i].face, along, toward});
  };
  const double to_centre = around == RingAround::Vertex ? 0.0 : 0.5;
  const bool ends_at_seam = closed || after != 0;
  const glm::dvec2 centre = ends_at_seam ? seen(last, to_centre, toward_next_face(around))
                                         : seen(first, to_centre, toward_previous_face(around));
  // Mirrored where the edges cross the seam, at the centre farther away.
  std::vector<glm::dvec2> values(n, centre);
  std::vector<bool> is_far(n, true);
  const auto mirror = [&](std::size_t i, std::size_t across, NetCorner::Toward toward) {
    values[i] = 2.0 * seen(across, kCrossing, toward) - value(polygon[across]);
    is_far[i] = false;
  };
  if (closed || first != 0) mirror(before, first, toward_previous_face(around));
  if (ends_at_seam) mirror(after, last, toward_next_face(around));
  for (std::size_t k = 0; k < chart.count; ++k) {
    const std::size_t i = (first + k) % n;
    values[i] = value(polygon[i]);
    is_far[i] = false;
  }
  if (closed) keep_mean(values, is_far, centre, first, chart.count);
  for (std::size_t i = 0; i < n; ++i) {
    if ((i + n - first) % n < chart.count) {
      face_uvs_.push_back(index_of(polygon[i]));
    } else {
      face_uvs_.push_back(static_cast<std::int32_t>(uvs_.size()));
      uvs_.push_back(values[i]);
    }
  }
}

void LevelOneUvs::move_to(PolygonMesh& net) {
  net.uvs = std::move(uvs_);
  net.face_uvs = std::move(face_uvs_);
}

}  // namespace planish
