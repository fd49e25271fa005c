#include "planish/surface/level_one_mesh.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

UsedPart usable_part(const PolygonMesh& mesh, std::shared_ptr<const PreparedMesh> prepared) {
  constexpr const char* kName = "control cage";
  if (!prepared) return used_part(mesh, prepare_mesh(mesh, kName));
  if (!positions_are_finite(mesh) || !attributes_are_sound(arrays_of(mesh)))
    require_usable(mesh, kName);
  return used_part(mesh, std::move(prepared));
}

SubdividedMesh::SubdividedMesh(const PolygonMesh& mesh, const SharpFeatureOptions& sharp,
                               std::shared_ptr<const PreparedMesh> prepared,
                               std::shared_ptr<const SharpFeatures> found)
    : used(usable_part(mesh, std::move(prepared))),
      features(found ? std::move(found)
                     : std::make_shared<const SharpFeatures>(find_sharp_features(
                           used.mesh, *used.prepared->topology, used.mesh.positions, sharp))),
      subdivision(*used.prepared->topology, *features, Weights::DooSabin) {}

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

namespace {

// The polygons of level 1 are the rings of control points around the vertices of Q_1, which come in
// the order: vertices, faces, edges of the mesh.

class MeshBuilder {
 public:
  // `net` has the vertices of the state, and their colours.
  MeshBuilder(const SubdividedMesh& base, PolygonMesh& net, std::vector<std::int32_t>* rings)
      : base_(base), mesh_(base.used.mesh), net_(net), rings_(rings), uvs_(base) {
    for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
      mesh_face_.insert(mesh_face_.end(), static_cast<std::size_t>(mesh_.face_size(f)), f);
    }
    is_hole_ = hole_flags(mesh_);
  }

  void add_polygons() {
    const auto first_edge = mesh_.vertex_count() + mesh_.face_count();
    const std::int32_t count = first_edge + base_.subdivision.topology().edge_count();
    for (std::int32_t v = 0; v < count; ++v) {
      gather_ring(base_.subdivision, v, ring_);
      around_ = v < first_edge ? RingAround::Vertex : RingAround::Edge;
      centre_ = ring_.corner_point;
      vertex_ = v;
      if (!ring_.sectors.empty()) {
        add_sectors();
      } else if (ring_.kind == VertexKind::Corner) {
        add_cone();
      } else if (ring_.kind == VertexKind::Dart) {
        const std::int32_t curve = curve_point_at(v);
        add_sector({0, static_cast<std::int32_t>(ring_.faces.size()), curve, curve});
      } else if (ring_.faces.size() >= 3) {
        add_smooth();
      }
    }
    uvs_.move_to(net_);
  }

 private:
  // Places in ring_.faces are taken modulo its size.
  [[nodiscard]] std::int32_t face(std::size_t place) const {
    return ring_.faces[place % ring_.faces.size()];
  }
  [[nodiscard]] bool is_hole(std::size_t place) const {
    return is_hole_[mesh_face_[face(place)]] != 0;
  }
  [[nodiscard]] bool is_cut(const VertexRing::Sector& sector) const {
    return end_of_run(sector.first, sector.first + sector.count) < sector.first + sector.count;
  }
  // The first place behind `begin` whose face is not within a hole where the other is, or `end`.
  [[nodiscard]] std::int32_t end_of_run(std::int32_t begin, std::int32_t end) const {
    std::int32_t place = begin + 1;
    while (place < end && is_hole(place) == is_hole(begin)) ++place;
    return place;
  }

  void push_face(std::size_t place) { polygon_.push_back({face(place), face(place)}); }
  // A point on the edge before the place: the leading edge at a vertex.
  void push_before(std::int32_t vertex, std::size_t place) {
    polygon_.push_back(
        {vertex, face(place), 0.25,
         around_ == RingAround::Vertex ? NetCorner::Toward::Next : NetCorner::Toward::Previous});
  }
  void push_after(std::int32_t vertex, std::size_t place) {
    polygon_.push_back(
        {vertex, face(place), 0.25,
         around_ == RingAround::Vertex ? NetCorner::Toward::Previous : NetCorner::Toward::Next});
  }
  // Around an edge, corners at its ends alternate.
  void push_centre(std::size_t place) {
    if (around_ == RingAround::Vertex) {
      polygon_.push_back({centre_, face(place), 0.0});
    } else {
      polygon_.push_back({centre_, face(place), 0.5,
                          place % 2 == 0 ? NetCorner::Toward::Previous : NetCorner::Toward::Next});
    }
  }

  void add_polygon(bool closed = false) {
    const std::int32_t owner = mesh_face_[polygon_.front().face];
    if (is_hole_[owner] != 0) net_.hole_faces.push_back(net_.face_count());
    vertices_.clear();
    for (const NetCorner& corner : polygon_) vertices_.push_back(corner.vertex);
    net_.add_face(vertices_);
    if (rings_ != nullptr) rings_->push_back(vertex_);
    if (!mesh_.face_groups.empty()) {
      net_.face_groups.push_back(mesh_.face_groups[owner]);
    }
    uvs_.add(polygon_, around_, closed);
    polygon_.clear();
  }

  void add_smooth() {
    const auto n = static_cast<std::int32_t>(ring_.faces.size());
    std::int32_t first = 0;
    while (first < n && is_hole(first) == is_hole(first + n - 1)) ++first;
    if (first == n) {
      for (std::int32_t i = 0; i < n; ++i) push_face(i);
      add_polygon(true);
      return;
    }
    centre_ = add_mean(ring_.faces);
    for (std::int32_t begin = first; begin < first + n;) {
      const std::int32_t end = end_of_run(begin, first + n);
      push_centre(begin);
      push_before(middle(begin + n - 1, begin), begin);
      for (std::int32_t i = begin; i < end; ++i) push_face(i);
      push_after(middle(end - 1, end), end - 1);
      add_polygon();
      begin = end;
    }
  }

  void add_sectors() {
    const VertexRing::Sector& front = ring_.sectors.front();
    const bool is_crease = ring_.kind == VertexKind::Crease;
    if (is_crease && std::ranges::any_of(ring_.sectors, [&](const auto& s) { return is_cut(s); })) {
      centre_ = add_mean({{front.curve0, front.curve1}});
    }
    for (const VertexRing::Sector& sector : ring_.sectors) {
      if (ring_.kind == VertexKind::Corner && is_interior(sector.curve0)) {
        tag_crease(ring_.corner_point, sector.curve0);
      }
      add_sector(sector);
    }
    if (!is_crease || ring_.sectors.size() != 2) return;
    if (centre_ < 0) {
      tag_crease(front.curve0, front.curve1);
    } else {
      tag_crease(front.curve0, centre_);
      tag_crease(centre_, front.curve1);
    }
  }

  // With curve points below 0 the sector has none.
  void add_sector(const VertexRing::Sector& sector) {
    const std::int32_t end = sector.first + sector.count;
    if (is_cut(sector) && centre_ < 0) centre_ = add_mean(ring_.faces);  // of a dart
    for (std::int32_t begin = sector.first; begin < end;) {
      const std::int32_t stop = end_of_run(begin, end);
      if (centre_ >= 0) push_centre(begin);
      if (begin > sector.first) {
        push_before(middle(begin - 1, begin), begin);
      } else if (sector.curve0 >= 0) {
        push_before(sector.curve0, begin);
      }
      for (std::int32_t i = begin; i < stop; ++i) push_face(i);
      const bool is_whole_dart = centre_ < 0 && sector.curve1 == sector.curve0;
      if (stop < end) {
        push_after(middle(stop - 1, stop), stop - 1);
      } else if (sector.curve1 >= 0 && !is_whole_dart) {
        push_after(sector.curve1, stop - 1);
      }
      add_polygon();
      begin = stop;
    }
  }

  // A tagged vertex without sharp edges.
  void add_cone() {
    const auto n = static_cast<std::int32_t>(ring_.faces.size());
    for (std::int32_t i = 0; i < n; ++i) add_sector({i, 2, -1, -1});
  }

  // Further vertices, where holes cut.
  std::int32_t add_mean(std::span<const std::int32_t> vertices) {
    const glm::dvec3 origin = net_.positions[vertices.front()];
    glm::dvec3 sum(0.0);
    glm::vec4 color(0.0f);
    for (const std::int32_t v : vertices) {
      sum += net_.positions[v] - origin;
      if (!net_.colors.empty()) color += net_.colors[v];
    }
    const auto count = static_cast<double>(vertices.size());
    net_.positions.push_back(origin + sum / count);
    if (!net_.colors.empty()) net_.colors.push_back(color / static_cast<float>(count));
    for (VertexAttribute& attribute : net_.attributes) {
      const auto width = static_cast<std::size_t>(attribute.width);
      for (std::size_t k = 0; k < width; ++k) {
        double of_all = 0;
        for (const std::int32_t v : vertices)
          of_all += attribute.values[width * static_cast<std::size_t>(v) + k];
        attribute.values.push_back(static_cast<float>(of_all / count));
      }
    }
    return net_.vertex_count() - 1;
  }
  std::int32_t middle(std::size_t place_a, std::size_t place_b) {
    const auto key = std::minmax({face(place_a), face(place_b)});
    const auto [found, is_new] = middles_.try_emplace(key, -1);
    if (is_new) found->second = add_mean(std::array{key.first, key.second});
    return found->second;
  }

  // The curve point at a vertex of the mesh where one sharp edge ends.
  [[nodiscard]] std::int32_t curve_point_at(std::int32_t vertex) const {
    const MeshTopology& topology = base_.subdivision.topology();
    for (const std::int32_t corner : topology.corners_at(vertex)) {
      const std::int32_t edge = topology.edge_of(corner);
      const std::int32_t sharp = base_.subdivision.sharp_of_edge(edge);
      if (sharp < 0) continue;
      const int end = topology.edge_vertices(edge).first == vertex ? 0 : 1;
      return base_.subdivision.first_sharp() + 2 * sharp + end;
    }
    PLANISH_ASSERT(!"no sharp edge ends here");
    return -1;
  }

  [[nodiscard]] bool is_interior(std::int32_t curve_point) const {
    const Subdivision& subdivision = base_.subdivision;
    const std::int32_t edge =
        subdivision.edge_of_sharp((curve_point - subdivision.first_sharp()) / 2);
    return !base_.subdivision.topology().is_boundary_edge(edge);
  }

  void tag_crease(std::int32_t a, std::int32_t b) {
    net_.creases.push_back({a, b, kInfiniteSharpness});
  }

  const SubdividedMesh& base_;
  const PolygonMesh& mesh_;
  PolygonMesh& net_;
  std::vector<std::int32_t>* rings_;
  LevelOneUvs uvs_;
  std::vector<std::int32_t> mesh_face_;  // of each corner
  std::vector<std::uint8_t> is_hole_;    // per face of the mesh
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles_;
  VertexRing ring_;
  RingAround around_ = RingAround::Vertex;
  std::int32_t vertex_ = 0;   // of Q_1, whose ring it is
  std::int32_t centre_ = -1;  // of the ring where its polygons hold it
  std::vector<NetCorner> polygon_;
  std::vector<std::int32_t> vertices_;
};

// A face's control point takes the mean of what is given at the corners of its face of Q_1:
// put(value) of each in order.
template <class Of, class Put>
void carry_once(const SubdividedMesh& base, const Of& of, const Put& put) {
  const PolygonMesh& mesh = base.used.mesh;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto vertices = mesh.face(f);
    const std::size_t m = vertices.size();
    glm::vec4 centre(0.0f);
    for (const std::int32_t v : vertices) centre += of(v) / static_cast<float>(m);
    for (std::size_t i = 0; i < m; ++i)
      put(0.25f * centre + 0.5f * of(vertices[i]) + 0.125f * of(vertices[(i + 1) % m]) +
          0.125f * of(vertices[(i + m - 1) % m]));
  }
  for (std::int32_t s = 0; s < base.features->sharp_edge_count; ++s) {
    const auto [v0, v1] =
        base.subdivision.topology().edge_vertices(base.subdivision.edge_of_sharp(s));
    const glm::vec4 a = of(v0), b = of(v1);
    put(0.75f * a + 0.25f * b);
    put(0.75f * b + 0.25f * a);
  }
  for (const std::int32_t v : base.features->corner_vertices) put(of(v));
}

void carry_attributes_once(const SubdividedMesh& base, PolygonMesh& result) {
  const PolygonMesh& mesh = base.used.mesh;
  if (!mesh.colors.empty())
    carry_once(
        base, [&](std::int32_t v) { return mesh.colors[v]; },
        [&](const glm::vec4& color) { result.colors.push_back(color); });
  for (const VertexAttribute& given : mesh.attributes) {
    VertexAttribute& made = result.attributes.emplace_back(
        attribute_of_size(given.name, given.width, result.positions.size()));
    for (int first = 0; first < given.width; first += 4) {
      std::size_t point = 0;
      carry_once(
          base, [&](std::int32_t v) { return given.four(static_cast<std::size_t>(v), first); },
          [&](const glm::vec4& four) { made.set_four(point++, first, four); });
    }
  }
}

}  // namespace

PolygonMesh level_one_mesh(const SubdividedMesh& base, const LevelOne& level_one,
                           std::vector<std::int32_t>* around) {
  require_state_size(base.subdivision.state_size(), level_one);
  PolygonMesh net;
  for (const glm::dvec3& point : level_one.state) {
    net.positions.push_back(level_one.placement.to_model(point));
  }
  carry_attributes_once(base, net);
  if (!base.used.mesh.face_groups.empty()) net.groups = base.used.mesh.groups;
  MeshBuilder(base, net, around).add_polygons();
  for (std::int32_t c = 0; c < base.features->corner_count; ++c) {
    net.corners.push_back({base.subdivision.first_corner() + c, kInfiniteSharpness});
  }
  return net;
}

PolygonMesh level_one_mesh(const PolygonMesh& mesh, const LevelOne& level_one,
                           const SharpFeatureOptions& sharp, std::vector<std::int32_t>* around) {
  return level_one_mesh(SubdividedMesh(mesh, sharp), level_one, around);
}

LevelOne level_one_of_cage(const PolygonMesh& mesh, const PolygonMesh& cage,
                           const SharpFeatureOptions& sharp) {
  const SubdividedMesh base(mesh, sharp);
  const auto size = static_cast<std::size_t>(base.subdivision.state_size());
  LevelOne level_one{cage.positions, {}};
  level_one.state.resize(std::min(size, cage.positions.size()));
  const PolygonMesh expected = level_one_mesh(base, level_one);
  if (cage.vertex_count() < expected.vertex_count()) {
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("it has {} vertices for {}", cage.vertex_count(), expected.vertex_count()));
  }
  if (cage.face_count() != expected.face_count()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("it has {} faces for {}", cage.face_count(), expected.face_count()));
  }
  for (std::int32_t f = 0; f < cage.face_count(); ++f) {
    if (std::ranges::equal(cage.face(f), expected.face(f))) continue;
    throw Error(ErrorCode::InvalidArgument, formatted("face {} has other corners", f), f);
  }
  return level_one;
}

}  // namespace planish
