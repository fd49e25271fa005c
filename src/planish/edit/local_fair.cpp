// Based on: fair/fair_net.h, whose construction is local but for the polish, which is minimised
// here on the part alone.
#include "planish/edit/local_fair.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "planish/mesh/mesh_topology.h"
#include "planish/surface/level_one.h"

namespace planish {

namespace {

// Rings of faces around what moves. Control points of the inner ones change; the others are there
// for these to be as in the whole net. Without polish, nothing farther off than 6 rings follows.
constexpr int kInnerRings = 6, kOuterRings = 5;

// From that part of all vertices on the whole net is made.
constexpr std::size_t kWholePart = 4;

template <class Value>
std::vector<Value> picked(const std::vector<Value>& values, std::span<const std::int32_t> places) {
  std::vector<Value> result;
  if (values.empty()) return result;
  result.reserve(places.size());
  for (const std::int32_t place : places) result.push_back(values[place]);
  return result;
}

}  // namespace

// Some faces of the mesh as a mesh. A vertex that they surround in several fans stands there once
// for each.
class LocalFair::Part {
 public:
  explicit Part(const LocalFair& whole) : whole_(whole) {
    const MeshTopology& topology = whole.subdivision_.topology();
    std::vector<std::int32_t> faces(whole.faces_.members().begin(), whole.faces_.members().end());
    std::ranges::sort(faces);
    std::vector<std::int32_t> first(faces.size() + 1, 0);
    for (std::size_t f = 0; f < faces.size(); ++f)
      first[f + 1] = first[f] + topology.face_size(faces[f]);
    corners_.reserve(static_cast<std::size_t>(first.back()));
    for (const std::int32_t face : faces)
      for (std::int32_t c = topology.first_corner(face); c < topology.first_corner(face + 1); ++c)
        corners_.push_back(c);
    mesh_.face_offsets.assign(first.begin(), first.end());
    mesh_.face_vertices.assign(corners_.size(), -1);
    const auto place_of = [&](std::int32_t corner) {
      return static_cast<std::size_t>(std::ranges::lower_bound(corners_, corner) -
                                      corners_.begin());
    };
    const auto is_in = [&](std::int32_t corner) {
      return corner >= 0 && whole.faces_.contains(topology.face_of(corner));
    };
    for (std::size_t k = 0; k < corners_.size(); ++k) {
      if (mesh_.face_vertices[k] >= 0) continue;
      std::int32_t begin = corners_[k];
      for (std::int32_t c = topology.cw(begin); is_in(c) && c != corners_[k]; c = topology.cw(c))
        begin = c;
      const auto own = static_cast<std::int32_t>(vertices_.size());
      vertices_.push_back(topology.vertex_of(begin));
      std::int32_t c = begin;
      do {
        mesh_.face_vertices[place_of(c)] = own;
        c = topology.ccw(c);
      } while (is_in(c) && c != begin);
    }
    mesh_.positions.resize(vertices_.size());
    tag();
    topology_ = std::make_unique<MeshTopology>(mesh_);
    features_ = find_sharp_features(mesh_, *topology_, mesh_.positions, {});
    subdivision_ = std::make_unique<Subdivision>(*topology_, features_, Weights::DooSabin);
    const FairDecisions& all = whole.decisions_;
    decisions_ = {picked(all.reversed, vertices_),      picked(all.halvings, vertices_),
                  picked(all.late_halvings, vertices_), picked(all.cures, vertices_),
                  picked(all.leans, vertices_),         picked(all.ellipses, vertices_),
                  planes_of(all.planes, faces)};
  }

  // Those whose face is in the part.
  [[nodiscard]] std::vector<KeptPlane> planes_of(std::span<const KeptPlane> all,
                                                 std::span<const std::int32_t> faces) const {
    std::vector<KeptPlane> planes;
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
      const auto at = std::ranges::equal_range(all, vertices_[v], {}, &KeptPlane::vertex);
      for (const KeptPlane& plane : at) {
        const auto face = std::ranges::lower_bound(faces, plane.face);
        if (face != faces.end() && *face == plane.face)
          planes.push_back(
              {static_cast<std::int32_t>(v), static_cast<std::int32_t>(face - faces.begin())});
      }
    }
    return planes;
  }

  // By the whole's given points of now.
  [[nodiscard]] std::vector<glm::dvec3> state() const {
    const std::vector<glm::dvec3> given = picked(whole_.given_, vertices_);
    return fair_net(mesh_, *subdivision_, given,
                    {whole_.polish_steps_, {}, &decisions_, whole_.cures_folds_})
        .state;
  }

  // Calls take(place in the part's state, place in the whole's, vertex) for all places.
  template <class Take>
  void for_places(const Take& take) const {
    const Subdivision& whole = whole_.subdivision_;
    const MeshTopology& topology = whole.topology();
    for (std::size_t k = 0; k < corners_.size(); ++k)
      take(k, corners_[k], topology.vertex_of(corners_[k]));
    for (std::int32_t s = 0; s < features_.sharp_edge_count; ++s) {
      const std::int32_t edge = subdivision_->edge_of_sharp(s);
      const std::int32_t other = topology.edge_of(corners_[topology_->corner_of(edge)]);
      const std::int32_t sharp = whole.sharp_of_edge(other);
      if (sharp < 0) continue;  // the part's rim
      const auto [v0, v1] = topology_->edge_vertices(edge);
      const std::int32_t first = topology.edge_vertices(other).first;
      for (int end = 0; end < 2; ++end) {
        const std::int32_t vertex = vertices_[end == 0 ? v0 : v1];
        take(subdivision_->first_sharp() + 2 * s + end,
             whole.first_sharp() + 2 * sharp + (vertex == first ? 0 : 1), vertex);
      }
    }
    for (std::int32_t i = 0; i < features_.corner_count; ++i) {
      const std::int32_t vertex = vertices_[features_.corner_vertices[i]];
      if (whole.features().corner_count == 0) continue;
      const std::int32_t corner = whole.features().corner_of_vertex[vertex];
      if (corner < 0) continue;
      take(subdivision_->first_corner() + i, whole.first_corner() + corner, vertex);
    }
  }

 private:
  // What is sharp in the whole, whatever made it so.
  void tag() {
    const Subdivision& whole = whole_.subdivision_;
    const MeshTopology& topology = whole.topology();
    for (std::size_t f = 0; f + 1 < mesh_.face_offsets.size(); ++f) {
      const std::int32_t first = mesh_.face_offsets[f], end = mesh_.face_offsets[f + 1];
      for (std::int32_t k = first; k < end; ++k) {
        const std::int32_t corner = corners_[k];
        const std::int32_t edge = topology.edge_of(corner);
        if (whole.sharp_of_edge(edge) < 0 || topology.corner_of(edge) != corner) continue;
        mesh_.creases.push_back({mesh_.face_vertices[k],
                                 mesh_.face_vertices[k + 1 == end ? first : k + 1],
                                 kInfiniteSharpness});
      }
    }
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      if (whole.features().vertex_kinds[vertices_[v]] == VertexKind::Corner)
        mesh_.corners.push_back({static_cast<std::int32_t>(v), kInfiniteSharpness});
  }

  const LocalFair& whole_;
  PolygonMesh mesh_;
  std::vector<std::int32_t> vertices_, corners_;  // of the whole
  std::unique_ptr<MeshTopology> topology_;
  SharpFeatures features_;
  std::unique_ptr<Subdivision> subdivision_;
  FairDecisions decisions_;
};

LocalFair::LocalFair(const PolygonMesh& mesh, const Subdivision& subdivision,
                     FairDecisions decisions, std::int32_t polish_steps, bool cures_folds,
                     std::vector<glm::dvec3> given)
    : mesh_(mesh),
      subdivision_(subdivision),
      decisions_(std::move(decisions)),
      polish_steps_(polish_steps),
      cures_folds_(cures_folds),
      given_(std::move(given)),
      near_(mesh.vertex_count()),
      faces_(mesh.face_count()) {}

void LocalFair::grow(std::span<const std::int32_t> vertices) {
  const MeshTopology& topology = subdivision_.topology();
  near_.clear();
  faces_.clear();
  for (const std::int32_t vertex : vertices) near_.add(vertex);
  std::size_t done = 0;
  for (int ring = 0; ring < kInnerRings + kOuterRings; ++ring) {
    if (ring == kInnerRings) inner_count_ = near_.members().size();
    for (const std::size_t end = near_.members().size(); done < end; ++done) {
      for (const std::int32_t corner : topology.corners_at(near_.members()[done])) {
        const std::int32_t face = topology.face_of(corner);
        if (!faces_.add(face)) continue;
        for (const std::int32_t other : topology.face(face)) near_.add(other);
      }
    }
  }
}

void LocalFair::put(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points) {
  for (std::size_t i = 0; i < vertices.size(); ++i) given_[vertices[i]] = points[i];
}

void LocalFair::move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points) {
  places_.clear();
  differences_.clear();
  changed_.clear();
  is_whole_ = false;
  if (vertices.empty()) return;
  grow(vertices);
  if (near_.members().size() * kWholePart >= given_.size()) {
    is_whole_ = true;
    put(vertices, points);
    return;
  }
  const Part part(*this);
  const std::vector<glm::dvec3> old_state = part.state();
  std::vector<glm::dvec3> before;
  for (const std::int32_t vertex : vertices) before.push_back(given_[vertex]);
  put(vertices, points);
  try {
    const std::vector<glm::dvec3> state = part.state();
    part.for_places([&](std::size_t own, std::int32_t place, std::int32_t vertex) {
      if (near_.place_of(vertex) >= inner_count_ || state[own] == old_state[own]) return;
      places_.push_back(place);
      differences_.push_back(state[own] - old_state[own]);
    });
    const auto inner = near_.members().first(inner_count_);
    changed_.assign(inner.begin(), inner.end());
  } catch (...) {
    put(vertices, before);
    throw;
  }
}

std::vector<glm::dvec3> LocalFair::whole_state(const Callbacks& callbacks) const {
  return fair_net(mesh_, subdivision_, given_,
                  {polish_steps_, callbacks, &decisions_, cures_folds_})
      .state;
}

MeasuredError LocalFair::measured(std::span<const glm::dvec3> state) const {
  const std::vector<glm::dvec3> limits = limit_points(subdivision_, state);
  return measure_error(limits.size(), [&](std::size_t v) { return limits[v] - given_[v]; });
}

}  // namespace planish
