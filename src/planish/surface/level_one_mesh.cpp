// The polygons of level 1 are the rings of control points around the vertices of Q_1, which come in
// the order: vertices, faces, edges of the mesh.
#include "planish/surface/level_one_mesh.h"

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/mesh/hole_flags.h"
#include "planish/surface/level_one_uvs.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

namespace {

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
