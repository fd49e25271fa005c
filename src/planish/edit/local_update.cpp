#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/edit/editor_impl.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/solve/backend.h"
#include "planish/solve/iteration.h"
#include "planish/surface/evaluate.h"

namespace planish {
namespace {

// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3.2: the
// iteration is local. Here by relaxation of single rows (Southwell 1946, in the order of a queue),
// which converges wherever B is positive definite in some scalar product.

// Of the tolerance: what moves solve to, so that control points, which are off by up to four times
// the residual on quads, stay within the tolerance of those of a solve from scratch; and what a
// solve of all rows goes to, so that many moves find room below that.
constexpr double kLocalShare = 0.125, kSettledShare = 0.0625;

// Of a row's residual, divided by its own weight, what is taken as step: a little more than all, as
// residuals beside each other mostly have one sign. The bound does not depend on it.
constexpr double kRelaxation = 1.15;

// Where a move is expected to touch more than that part of all vertices, and so many, all rows are
// solved and evaluated at less cost.
constexpr std::size_t kWholeShare = 16, kFewVertices = 512;

// By what a change shrinks from one vertex to the next along edges: of quads 3 - 2 sqrt(2), by
// which (1, 6, 1) / 8 is inverted. Measured, it goes as far over a triangle as over 3/4 of a quad,
// over an octagon as over two.
constexpr double kDecay = 0.1716, kQuadSize = 4;

// What a moved vertex hardly ever goes beyond.
constexpr std::size_t kMostReached = 512;

// How far what is touched may go beyond what was expected.
constexpr double kMostExcess = 1.5;

// A move that looks at so many rows for each vertex of the mesh does not converge by itself.
constexpr std::int64_t kMostLooks = 64;

constexpr std::size_t kSolveGrain = 4096;

}  // namespace

LocalSolve::LocalSolve(LimitSystem system, std::shared_ptr<const MeshTopology> topology,
                       std::vector<glm::dvec3> given, std::vector<glm::dvec3> control,
                       double tolerance, const Callbacks& callbacks)
    : system_(std::move(system)),
      topology_(std::move(topology)),
      given_(std::move(given)),
      control_(std::move(control)),
      tolerance_(tolerance),
      touched_(topology_->vertex_count()),
      fresh_faces_(0),
      is_queued_(given_.size(), 0) {
  if (const std::int32_t count = system_.masks.view().sum_count(); count > 0) {
    for (std::int32_t f = 0; f < topology_->face_count(); ++f)
      if (topology_->face_size(f) >= kSummedRing) large_faces_.push_back(f);
    sums_per_face_ = count / static_cast<std::int32_t>(large_faces_.size());
    fresh_faces_ = SparseSet(static_cast<std::int32_t>(large_faces_.size()));
  }
  settle(callbacks);
}

glm::dvec3 LocalSolve::residual(std::int32_t row) const {
  const StencilTable& rows = system_.masks.rows;
  const auto count = static_cast<std::int32_t>(control_.size());
  glm::dvec3 result = given_[row];
  const std::int32_t first = rows.offsets[row];
  for (std::int32_t k = first; k < first + rows.sizes[row]; ++k) {
    const std::int32_t source = rows.indices[k];
    result -= rows.weights[k] * (source < count ? control_[source] : sums_[source - count]);
  }
  return result;
}

std::int32_t LocalSolve::first_sum_of(std::int32_t face) const {
  const auto found = std::ranges::lower_bound(large_faces_, face);
  return sums_per_face_ * static_cast<std::int32_t>(found - large_faces_.begin());
}

// Sums follow steps one by one; made anew once a move, they keep the bits of one.
void LocalSolve::refresh_sums_at(std::int32_t vertex) {
  const StencilTable& table = system_.masks.sums;
  for (const std::int32_t corner : topology_->corners_at(vertex)) {
    const std::int32_t face = topology_->face_of(corner);
    if (topology_->face_size(face) < kSummedRing) continue;
    const std::int32_t first = first_sum_of(face);
    if (!fresh_faces_.add(first / sums_per_face_)) continue;
    for (std::int32_t s = first; s < first + sums_per_face_; ++s) {
      glm::dvec3 sum(0.0);
      for (std::int32_t k = table.offsets[s]; k < table.offsets[s] + table.sizes[s]; ++k)
        sum += table.weights[k] * control_[table.indices[k]];
      sums_[s] = sum;
    }
  }
}

void LocalSolve::touch(std::int32_t vertex) {
  if (touched_.contains(vertex)) return;
  const auto at = static_cast<std::size_t>(vertex);
  before_.push_back({given_[at], control_[at]});
  touched_.add(vertex);
  if (!large_faces_.empty()) refresh_sums_at(vertex);
}

void LocalSolve::wake(std::int32_t vertex) {
  if (is_queued_[vertex] != 0) return;
  queue_.push_back(vertex);
  is_queued_[vertex] = 1;
}

// Rows that name a vertex are of vertices of its faces.
void LocalSolve::shift(std::int32_t vertex, const glm::dvec3& step) {
  touch(vertex);
  control_[vertex] += step;
  wake(vertex);
  for (const std::int32_t corner : topology_->corners_at(vertex)) {
    const std::int32_t face = topology_->face_of(corner);
    for (const std::int32_t other : topology_->face(face)) wake(other);
    if (topology_->face_size(face) < kSummedRing || large_faces_.empty()) continue;
    const StencilTable& table = system_.masks.sums;
    const std::int32_t first = first_sum_of(face);
    for (std::int32_t s = first; s < first + sums_per_face_; ++s)
      sums_[s] += table.weights[table.offsets[s] + topology_->place_of(corner)] * step;
  }
}

std::size_t LocalSolve::most_touched() const {
  return std::max(kFewVertices, control_.size() / kWholeShare);
}

// Counts the vertices that are as near to moved ones, along edges, as changes go that begin with
// their ways, and stops where these are too many: some hundredths of what relaxing them costs.
bool LocalSolve::reaches_many(std::span<const std::int32_t> vertices,
                              std::span<const glm::dvec3> points) {
  const std::size_t most = most_touched();
  if (vertices.size() > most) return true;
  if (vertices.size() * kMostReached <= most) return false;
  SparseSet& reached = touched_;  // which is empty as yet, and is left so
  for (auto& ring : rings_) ring.clear();
  const auto enter = [&](std::int32_t vertex, long rings) {
    const auto left = static_cast<std::size_t>(rings);
    if (rings_.size() <= left) rings_.resize(left + 1);
    rings_[left].push_back(vertex);
  };
  const double face_size = static_cast<double>(topology_->corner_count()) / topology_->face_count();
  const double rings_per_e = face_size / kQuadSize / -portable::log(kDecay);
  constexpr double kMostRings = 64;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double way = glm::length(points[i] - given_[vertices[i]]);
    const double rings = portable::log(way / bound_) * rings_per_e;  // of none: below 0
    enter(vertices[i], rings > 0 ? std::lround(std::min(rings, kMostRings)) : 0);
  }
  for (std::size_t left = rings_.size(); left-- > 0 && reached.members().size() <= most;) {
    for (std::size_t i = 0; i < rings_[left].size() && reached.members().size() <= most; ++i) {
      const std::int32_t vertex = rings_[left][i];
      if (!reached.add(vertex)) continue;
      if (left == 0) continue;
      for (const std::int32_t corner : topology_->corners_at(vertex))
        for (const std::int32_t other : {topology_->next(corner), topology_->prev(corner)})
          if (const std::int32_t v = topology_->vertex_of(other); !reached.contains(v))
            rings_[left - 1].push_back(v);
    }
  }
  const bool reaches_many = reached.members().size() > most;
  reached.clear();
  return reaches_many;
}

// False where it does not come to an end, or all rows are better solved.
bool LocalSolve::relax() {
  const double least = bound_ * bound_;
  const auto most_vertices =
      static_cast<std::size_t>(kMostExcess * static_cast<double>(most_touched()));
  const std::int64_t most = kMostLooks * static_cast<std::int64_t>(control_.size());
  const StencilTable& rows = system_.masks.rows;
  StopCheck stop;
  std::size_t next = 0;
  while (next < queue_.size()) {
    stop.step();
    if (++row_count_ > most || touched_.members().size() > most_vertices) return false;
    const std::int32_t row = queue_[next++];
    is_queued_[row] = 0;
    // What has been looked at is dropped, at less cost than that of the looks.
    if (next > 1024 && 2 * next > queue_.size()) {
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(next));
      next = 0;
    }
    const glm::dvec3 left = residual(row);
    const double square = glm::dot(left, left);
    if (square <= least) continue;
    if (!std::isfinite(square)) return false;
    double own = 0;
    const std::int32_t first = rows.offsets[row];
    for (std::int32_t k = first; k < first + rows.sizes[row]; ++k)
      if (rows.indices[k] == row) own = rows.weights[k];
    // Rows of corners name their vertex alone: they are met at once.
    const double share = rows.sizes[row] == 1 ? 1.0 : kRelaxation / std::max(own, 0.25);
    shift(row, share * left);
  }
  queue_.clear();
  return true;
}

void LocalSolve::take_back() {
  for (const std::int32_t row : queue_) is_queued_[row] = 0;
  queue_.clear();
  const auto members = touched_.members();
  for (std::size_t i = 0; i < members.size(); ++i) {
    const auto at = static_cast<std::size_t>(members[i]);
    given_[at] = before_[i].given;
    control_[at] = before_[i].control;
  }
  fresh_faces_.clear();
  for (const std::int32_t vertex : members) refresh_sums_at(vertex);
}

void LocalSolve::move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points) {
  touched_.clear();
  before_.clear();
  fresh_faces_.clear();
  row_count_ = 0;
  changed_all_ = false;
  const bool is_local = !reaches_many(vertices, points);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    touch(vertices[i]);
    const auto at = static_cast<std::size_t>(vertices[i]);
    // The surface goes along, to first order: half of the way is saved.
    const glm::dvec3 way = points[i] - given_[at];
    given_[at] = points[i];
    if (is_local)
      shift(vertices[i], way);
    else
      control_[at] += way;
  }
  try {
    if (!is_local || !relax()) {
      for (const std::int32_t row : queue_) is_queued_[row] = 0;
      queue_.clear();
      settle();
    }
  } catch (...) {
    take_back();
    throw;
  }
}

void LocalSolve::settle(const Callbacks& callbacks) {
  const std::vector<glm::dvec3> before = control_;
  try {
    const auto backend = make_cpu_backend();
    const SummedView masks = system_.masks.view();
    sums_ = sums_of(masks, control_);
    std::vector<glm::dvec3> left(control_.size());
    parallel_each(left.size(), kSolveGrain, [&](std::int32_t v) { left[v] = residual(v); });
    double longest = 0;
    for (const glm::dvec3& r : left) longest = std::max(longest, glm::length(r));
    InterpolationOptions options;
    options.tolerance = kSettledShare * tolerance_;
    options.spectral_bound = system_.spectral_bound;
    options.max_iterations = 1000;
    options.callbacks = callbacks;
    if (longest > options.tolerance) {
      const std::unique_ptr<Solve> solve = backend->make_solve(masks);
      solve->begin(left);
      Interpolation result;
      take_steps(*solve, longest, options, result);
      const std::vector<glm::dvec3> steps = solve->displacement();
      parallel_each(steps.size(), kSolveGrain, [&](std::size_t v) { control_[v] += steps[v]; });
      sums_ = sums_of(masks, control_);
      longest = measured().norms.max;
    }
    if (!(longest <= tolerance_)) {
      throw Error(ErrorCode::InvalidArgument,
                  formatted("the equations of this mesh are solved to {} of the diagonal, the "
                            "tolerance is {}; take a larger tolerance, or fair interpolation",
                            shortest(longest), shortest(tolerance_)));
    }
    // Where rounding ends above the tolerance's share, moves end there as well.
    bound_ = std::max(kLocalShare * tolerance_, 2 * longest);
    changed_all_ = true;
  } catch (...) {
    control_ = before;
    sums_ = sums_of(system_.masks.view(), control_);
    throw;
  }
}

MeasuredError LocalSolve::measured() const {
  return measure_error(control_.size(), [&](std::int32_t v) { return residual(v); });
}

namespace {

// Based on: fair/fair_net.h, whose construction is local but for the polish, which is minimised
// here on the part alone.

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

namespace {

// Corner patches are local: that of corner c of face f takes control points of the faces around c's
// vertex alone (patches/README.md).

// Rows that a thread takes at least.
constexpr std::size_t kRowGrain = 1 << 13;

// `surface`, of which no row is numbered before it is known that there is such a level, and room.
const DooSabinSurface& required(const DooSabinSurface& surface, const EvaluateOptions& options) {
  surface.require_whole(options.level, options.memory_limit_bytes, nullptr);
  return surface;
}

}  // namespace

EditedSurface::EditedSurface(const PolygonMesh& mesh, const Placement& placement,
                             std::span<const glm::dvec3> cage, std::span<const glm::dvec3> state,
                             const EvaluateOptions& options)
    : surface_(std::make_shared<DooSabinSurface>(mesh, placement, cage, state, options)),
      patches_(required(*surface_, options).patches(),
               {options.level, options.weights, surface_->hidden()}),
      weights_(options.weights),
      touched_(surface_->topology().face_count()),
      around_(surface_->topology().face_count()) {
  const auto count = static_cast<std::size_t>(patches_.numbering().row_count());
  positions_.resize(count);
  normals_.resize(count);
  make_all_rows();
}

void EditedSurface::make_all_rows() {
  const std::span<const PatchTile> tiles = patches_.tiles();
  parallel_each(tiles.size(), 1, [&](std::size_t t) {
    const auto first = static_cast<std::size_t>(tiles[t].first_row);
    const auto count = static_cast<std::size_t>(tiles[t].row_count);
    PatchTarget target;
    target.positions = std::span(positions_).subspan(first, count);
    target.normals = std::span(normals_).subspan(first, count);
    (void)patches_.rows(surface_->state(), surface_->placement(),
                        {tiles[t].first_row, tiles[t].row_count}, target);
  });
  ranges_.assign(1, {0, static_cast<std::int64_t>(positions_.size())});
  corners_.clear();
  const std::int32_t count = surface_->topology().corner_count();
  for (std::int32_t c = 0; c < count; ++c) corners_.push_back(c);
}

void EditedSurface::touch_faces_at(std::int32_t vertex) {
  const MeshTopology& topology = surface_->topology();
  for (const std::int32_t corner : topology.corners_at(vertex))
    touched_.add(topology.face_of(corner));
}

void EditedSurface::list_faces_around() {
  const MeshTopology& topology = surface_->topology();
  around_.clear();
  for (const std::int32_t face : touched_.members()) {
    for (const std::int32_t vertex : topology.face(face))
      for (const std::int32_t corner : topology.corners_at(vertex))
        around_.add(topology.face_of(corner));
  }
  faces_.assign(around_.members().begin(), around_.members().end());
  std::ranges::sort(faces_);
  corners_.clear();
  for (const std::int32_t face : faces_) {
    if (patches_.numbering().is_hidden(face)) continue;
    for (std::int32_t c = topology.first_corner(face); c < topology.first_corner(face + 1); ++c)
      corners_.push_back(c);
  }
}

// Parts of the numbering follow one another; faces come in order, so only rows of vertices and
// edges are to be sorted, of which there are few.
void EditedSurface::list_rows() {
  const PatchNumbering& numbering = patches_.numbering();
  const MeshTopology& topology = surface_->topology();
  const PatchMesh& mesh = surface_->patches();
  rows_.clear();
  points_.clear();
  const bool has_level = numbering.level() > 0;
  const int side = numbering.samples().side();
  const bool has_cuts = mesh.features().sharp_edge_count > 0 || numbering.has_hidden();
  for (const std::int32_t c : corners_) {
    points_.push_back(numbering.vertex_row(c));
    if (!has_level) continue;
    points_.push_back(numbering.edge_row(c));
    // Those of its trailing edge are another corner's, but at a cut.
    for (int i = 1; i < side && has_cuts; ++i) points_.push_back(numbering.row(c, 0, i));
    if (topology.place_of(c) == 0) points_.push_back(numbering.face_row(topology.face_of(c)));
    const auto first = static_cast<std::int32_t>(numbering.corner_row(c));
    for (std::int32_t i = 0; i < numbering.corner_row_count(c); ++i) rows_.push_back(first + i);
  }
  std::ranges::sort(points_);
  points_.erase(std::ranges::unique(points_).begin(), points_.end());
  const std::size_t count = rows_.size();
  rows_.insert(rows_.end(), points_.begin(), points_.end());
  std::inplace_merge(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(count),
                     rows_.end());
  if (has_cuts) rows_.erase(std::ranges::unique(rows_).begin(), rows_.end());
  ranges_.clear();
  for (const std::int32_t row : rows_) {
    if (ranges_.empty() || ranges_.back().first + ranges_.back().count != row)
      ranges_.push_back({row, 0});
    ++ranges_.back().count;
  }
}

void EditedSurface::make_rows() {
  parallel_for(rows_.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    thread_local std::vector<glm::dvec3> positions;
    thread_local std::vector<glm::vec3> normals;
    const auto rows = std::span<const std::int32_t>(rows_).subspan(begin, end - begin);
    positions.resize(rows.size());
    normals.resize(rows.size());
    PatchTarget target;
    target.positions = positions;
    target.normals = normals;
    (void)patches_.rows_at(surface_->state(), surface_->placement(), rows, target);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      positions_[rows[i]] = positions[i];
      normals_[rows[i]] = normals[i];
    }
  });
}

// After touched_ has the faces whose points of level 1 are others.
void EditedSurface::follow_touched() {
  list_faces_around();
  surface_->patches().update_sums_at(corners_, surface_->own_state());
  list_rows();
  make_rows();
}

void EditedSurface::update(std::span<const std::int32_t> vertices,
                           std::span<const glm::dvec3> cage) {
  touched_.clear();
  for (const std::int32_t vertex : vertices) touch_faces_at(vertex);
  update_first_step(surface_->patches(), weights_, cage, touched_.members(), surface_->own_state());
  follow_touched();
}

void EditedSurface::update_all(std::span<const glm::dvec3> cage) {
  const RawVector<glm::dvec3> state = first_step(surface_->patches(), weights_.weights(), cage);
  std::ranges::copy(state, surface_->own_state().begin());
  make_all_rows();
}

void EditedSurface::add_to_state(std::span<const std::int32_t> places,
                                 std::span<const glm::dvec3> differences) {
  const MeshTopology& topology = surface_->topology();
  const std::int32_t corner_count = surface_->patches().first_sharp();
  touched_.clear();
  for (std::size_t i = 0; i < places.size(); ++i) {
    surface_->own_state()[places[i]] += differences[i];
    if (places[i] < corner_count) touched_.add(topology.face_of(places[i]));
  }
  follow_touched();
}

void EditedSurface::set_state_all(std::span<const glm::dvec3> state) {
  std::ranges::copy(state, surface_->own_state().begin());
  surface_->patches().update_sums(surface_->own_state());
  make_all_rows();
}

}  // namespace planish
