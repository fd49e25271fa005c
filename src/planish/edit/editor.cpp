#include "planish/edit/editor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <queue>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/edit/editor_impl.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"

namespace planish {

Selection select_around(const PreparedMesh& prepared, std::span<const glm::dvec3> positions,
                        std::span<const std::int32_t> vertices, double radius) {
  if (!(radius > 0) || !std::isfinite(radius)) {
    throw Error(ErrorCode::InvalidArgument,
                "the radius " + std::to_string(radius) +
                    " is not above 0 and finite; take a length in the mesh's unit");
  }
  const MeshTopology& topology = *prepared.topology;
  const auto position = [&](std::int32_t used) -> const glm::dvec3& {
    return positions[prepared.vertices[used]];
  };
  // Dijkstra; ties go by the vertex, so that the order is always the same.
  using Reached = std::pair<double, std::int32_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
  std::unordered_map<std::int32_t, double> distances;
  const auto reach = [&](std::int32_t vertex, double distance) {
    const auto [at, is_new] = distances.try_emplace(vertex, distance);
    if (!is_new && at->second <= distance) return;
    at->second = distance;
    open.push({distance, vertex});
  };
  for (const std::int32_t vertex : vertices) {
    const auto used = std::ranges::lower_bound(prepared.vertices, vertex);
    if (used != prepared.vertices.end() && *used == vertex)
      reach(static_cast<std::int32_t>(used - prepared.vertices.begin()), 0);
  }
  Selection result;
  while (!open.empty()) {
    const auto [distance, vertex] = open.top();
    open.pop();
    if (distance > distances[vertex]) continue;
    const double part = distance / radius, fall = 1 - part * part;
    result.vertices.push_back(prepared.vertices[vertex]);
    result.weights.push_back(fall * fall);
    for (const std::int32_t corner : topology.corners_at(vertex)) {
      for (const std::int32_t c : {topology.next(corner), topology.prev(corner)}) {
        const std::int32_t other = topology.vertex_of(c);
        const double there = distance + glm::length(position(other) - position(vertex));
        if (there < radius) reach(other, there);
      }
    }
  }
  return result;
}

namespace {

template <class Place>
glm::dvec3 mean_of(const AddedVertex& added, const Place& place) {
  glm::dvec3 mean(0.0);
  for (int i = 0; i < 3; ++i) mean += added.weights[i] * place(added.vertices[i]);
  return mean;
}

}  // namespace

Followers::Followers(std::span<const AddedVertex> added, std::span<const glm::dvec3> positions)
    : added_(added.begin(), added.end()) {
  if (added.empty()) return;
  const std::int32_t leaders = leader_count(positions.size());
  const auto place = [&](std::int32_t v) { return positions[v]; };
  starts_.assign(static_cast<std::size_t>(leaders) + 1, 0);
  for (std::size_t i = 0; i < added.size(); ++i) {
    offsets_.push_back(positions[leaders + i] - mean_of(added[i], place));
    for (const std::int32_t v : added[i].vertices) ++starts_[v + 1];
  }
  for (std::int32_t v = 0; v < leaders; ++v) starts_[v + 1] += starts_[v];
  led_by_.resize(static_cast<std::size_t>(starts_.back()));
  std::vector<std::int32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < added.size(); ++i)
    for (const std::int32_t v : added[i].vertices)
      led_by_[next[v]++] = static_cast<std::int32_t>(i);
}

void Followers::follow(std::span<const glm::dvec3> positions, std::vector<std::int32_t>& vertices,
                       std::vector<glm::dvec3>& to) const {
  if (empty()) return;
  const std::int32_t leaders = leader_count(positions.size());
  std::unordered_map<std::int32_t, glm::dvec3> moved;  // of a vertex named twice the last counts
  for (std::size_t i = 0; i < vertices.size(); ++i) moved[vertices[i]] = to[i];
  std::vector<std::int32_t> following;
  for (const std::int32_t v : vertices)
    following.insert(following.end(), led_by_.begin() + starts_[v],
                     led_by_.begin() + starts_[v + 1]);
  std::ranges::sort(following);
  following.erase(std::unique(following.begin(), following.end()), following.end());
  const auto place = [&](std::int32_t v) {
    const auto found = moved.find(v);
    return found == moved.end() ? positions[v] : found->second;
  };
  for (const std::int32_t i : following) {
    vertices.push_back(leaders + i);
    to.push_back(mean_of(added_[i], place) + offsets_[i]);
  }
}

namespace {

// Farther off, coordinates of unit diagonal lose what the tolerance asks for.
constexpr double kFarthestMove = 1e6;

// Throws Error{InvalidArgument} where an Editor cannot take a fit, with what to do instead.
void require_editable(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options) {
  require_level(options.level);
  if (!fit.points.empty()) {
    throw Error(ErrorCode::InvalidArgument,
                "the fit leaves the vertices within a bound, so that moving one has no place to "
                "go to; edit a fit with within = 0");
  }
  if (!fit.interpolation.converged) {
    throw Error(ErrorCode::InvalidArgument,
                "the fit has not reached its tolerance (" +
                    std::string(name_of(fit.interpolation.stop_reason)) +
                    "); fit again with more iterations or a larger tolerance, or take fair "
                    "interpolation");
  }
  if (fit.prepared == nullptr || fit.prepared->given_vertex_count != mesh.vertex_count()) {
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("the fit is of {} vertices, the mesh has {}; give the mesh that was fitted",
                  fit.prepared ? fit.prepared->given_vertex_count : 0, mesh.vertex_count()));
  }
  if (options.fit.scheme != Scheme::DooSabin) {
    throw Error(ErrorCode::InvalidArgument,
                "fits of another scheme than Doo-Sabin cannot be edited; fit again with scheme "
                "doo-sabin");
  }
}

// Throws Error{InvalidArgument} for moves of vertices that are not there, or to where the surface
// would lose digits.
void require_moves(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> positions,
                   std::int32_t vertex_count, const Placement& placement) {
  if (vertices.size() != positions.size()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("move: there are {} vertices and {} positions; give one each",
                          vertices.size(), positions.size()));
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto name = [&] { return formatted("move {}: ", i); };
    if (vertices[i] < 0 || vertices[i] >= vertex_count) {
      throw Error(ErrorCode::InvalidArgument,
                  formatted("{}there is no vertex {}; the mesh has 0 to {}", name(), vertices[i],
                            vertex_count - 1),
                  vertices[i]);
    }
    const glm::dvec3 unit = placement.to_unit(positions[i]);
    const double far = std::max({std::abs(unit.x), std::abs(unit.y), std::abs(unit.z)});
    if (far <= kFarthestMove && !std::isnan(unit.x + unit.y + unit.z)) continue;
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}the position of vertex {} is not finite or farther than 10^6 "
                          "diagonals off; fit the moved mesh anew",
                          name(), vertices[i]),
                vertices[i]);
  }
}

void require_sharpness(float sharpness, std::int32_t vertex) {
  if (sharpness == 0 || sharpness == kInfiniteSharpness) return;
  throw Error(ErrorCode::InvalidArgument,
              "set_sharp: the sharpness " + std::to_string(sharpness) + " at vertex " +
                  std::to_string(vertex) + " is neither 0, smooth, nor 10, sharp",
              vertex);
}

std::int32_t used_vertex(const PreparedMesh& prepared, std::int32_t vertex) {
  const auto found = std::ranges::lower_bound(prepared.vertices, vertex);
  if (found != prepared.vertices.end() && *found == vertex)
    return static_cast<std::int32_t>(found - prepared.vertices.begin());
  throw Error(ErrorCode::InvalidArgument, formatted("set_sharp: no face has a vertex {}", vertex),
              vertex);
}

// Sets tags of a mesh, or takes them away where the sharpness is 0. `prepared` is of its faces.
// Throws Error{InvalidArgument} for an edge or vertex that is not there, and for a sharpness that
// is neither 0 nor kInfiniteSharpness.
void tag_sharp(const PreparedMesh& prepared, std::span<const CreaseEdge> edges,
               std::span<const CornerVertex> corners, PolygonMesh& mesh) {
  std::map<std::pair<std::int32_t, std::int32_t>, float> of_edge;
  for (const CreaseEdge& edge : edges) {
    require_sharpness(edge.sharpness, edge.v0);
    if (prepared.topology->find_edge(used_vertex(prepared, edge.v0),
                                     used_vertex(prepared, edge.v1)) < 0) {
      throw Error(ErrorCode::InvalidArgument,
                  formatted("set_sharp: vertices {} and {} have no edge; name two that follow one "
                            "another in a face",
                            edge.v0, edge.v1),
                  edge.v0);
    }
    of_edge[std::minmax(edge.v0, edge.v1)] = edge.sharpness;
  }
  std::map<std::int32_t, float> of_vertex;
  for (const CornerVertex& corner : corners) {
    require_sharpness(corner.sharpness, corner.vertex);
    (void)used_vertex(prepared, corner.vertex);
    of_vertex[corner.vertex] = corner.sharpness;
  }
  std::erase_if(mesh.creases, [&](const CreaseEdge& crease) {
    return of_edge.contains(std::minmax(crease.v0, crease.v1));
  });
  std::erase_if(mesh.corners,
                [&](const CornerVertex& corner) { return of_vertex.contains(corner.vertex); });
  for (const auto& [ends, sharpness] : of_edge)
    if (sharpness > 0) mesh.creases.push_back({ends.first, ends.second, sharpness});
  for (const auto& [vertex, sharpness] : of_vertex)
    if (sharpness > 0) mesh.corners.push_back({vertex, sharpness});
}

// What a centroid of a dozen points may be off by after differences have been added to these.
constexpr double kFairRounding = 4e-16;

Fit without_arrays(const Fit& fit) {
  Fit result;
  result.interpolation.iterations = fit.interpolation.iterations;
  result.placement = fit.placement;
  result.prepared = fit.prepared;
  result.spectral_bound = fit.spectral_bound;
  result.stencil_entries = fit.stencil_entries;
  return result;
}

}  // namespace

Editor::Impl::Impl(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options,
                   const Callbacks& callbacks)
    : mesh_(mesh),
      options_(options),
      fit_(without_arrays(fit)),
      points_(mesh.positions),
      used_(used_part(mesh, fit.prepared)),
      past_(options.undo_steps, mesh.positions.size()),
      future_(options.undo_steps, mesh.positions.size()) {
  options_.fit.callbacks = {};
  const auto unit = [&](const std::vector<glm::dvec3>& positions) {
    std::vector<glm::dvec3> result(used_.vertices.size());
    parallel_each(result.size(), [&](std::size_t v) {
      result[v] = fit_.placement.to_unit(positions[used_.vertices[v]]);
    });
    return result;
  };
  fit_.features = std::make_shared<const SharpFeatures>(find_sharp_features(
      used_.mesh, *fit.prepared->topology, used_.mesh.positions, options.fit.sharp));
  const SharpFeatures& features = *fit_.features;
  fit_.sharp_edge_count = features.sharp_edge_count;
  fit_.boundary_edge_count = features.sharp_edge_count - features.interior_sharp_edge_count;
  fit_.corner_count = features.corner_count;
  // A fair net's first step takes the weights of 1978 whatever the later levels take.
  subdivision_.emplace(*fit.prepared->topology, features,
                       fit.fair ? Weights::DooSabin : options.fit.weights);
  if (fit.fair) {
    fair_.emplace(used_.mesh, *subdivision_, fit.fair->decisions, options.fit.polish_steps,
                  options.fit.cures_folds, unit(mesh.positions));
  } else {
    LimitSystem system = doo_sabin_system(used_.mesh, *subdivision_, options_.fit);
    fit_.spectral_bound = system.spectral_bound;
    fit_.stencil_entries = system.masks.entry_count();
    solve_.emplace(std::move(system), fit.prepared->topology, unit(mesh.positions),
                   unit(fit.cage.positions), options.fit.tolerance, callbacks);
  }
  EvaluateOptions evaluate;
  evaluate.level = options.level;
  evaluate.weights = options.fit.weights;
  evaluate.features = fit_.features;
  evaluate.prepared = fit.prepared;
  surface_.emplace(mesh, fit_.placement, solve_ ? solve_->control() : std::span<const glm::dvec3>{},
                   fit.fair ? std::span<const glm::dvec3>(fit.fair->level_one.state)
                            : std::span<const glm::dvec3>{},
                   evaluate);
  bound_ = fit.interpolation.error.max;
}

Editor::Impl::Impl(std::unique_ptr<const PolygonMesh> mesh, const Fit& fit,
                   const EditorOptions& options, const Callbacks& callbacks)
    : Impl(*mesh, fit, options, callbacks) {
  own_mesh_ = std::move(mesh);
}

std::unique_ptr<Editor::Impl> Editor::Impl::with_sharp(std::span<const CreaseEdge> edges,
                                                       std::span<const CornerVertex> corners,
                                                       const Callbacks& callbacks) const {
  const HostScope host(callbacks);
  check_stop();  // small meshes have no loop that looks
  if (!options_.fit.sharp.use_tags) {
    throw Error(ErrorCode::InvalidArgument,
                "set_sharp: the fit does not look at tags; fit again with sharp.use_tags");
  }
  auto mesh = std::make_unique<PolygonMesh>(this->mesh());
  tag_sharp(*fit_.prepared, edges, corners, *mesh);
  const Fit now = fair_ ? fit_anew(*mesh, callbacks) : fit();
  return next(std::move(mesh), now, callbacks);
}

std::unique_ptr<Editor::Impl> Editor::Impl::refitted(const Callbacks& callbacks) const {
  const HostScope host(callbacks);
  check_stop();
  auto mesh = std::make_unique<PolygonMesh>(this->mesh());
  const Fit now = fit_anew(*mesh, callbacks);
  require_editable(*mesh, now, options_);
  return next(std::move(mesh), now, callbacks);
}

// Of a mesh that differs from the first by tags and positions.
Fit Editor::Impl::fit_anew(const PolygonMesh& mesh, const Callbacks& callbacks) const {
  FitOptions again = options_.fit;
  again.method = fair_ ? InterpolationMethod::Fair : InterpolationMethod::Progressive;
  again.fair_decisions = nullptr;
  again.within = 0.0;
  again.prepared = fit_.prepared;
  again.callbacks = callbacks;
  return planish::fit(mesh, *make_cpu_backend(), again);
}

// The session goes on with it.
std::unique_ptr<Editor::Impl> Editor::Impl::next(std::unique_ptr<const PolygonMesh> mesh,
                                                 const Fit& fit, const Callbacks& callbacks) const {
  auto result = std::make_unique<Impl>(std::move(mesh), fit, options_, callbacks);
  result->past_ = past_;
  result->future_ = future_;
  result->followers_ = followers_;
  return result;
}

EditChange Editor::Impl::all_rows() {
  moved_.clear();
  control_points_.assign(used_.vertices.begin(), used_.vertices.end());
  return finish(true, false);
}

EditChange Editor::Impl::move(std::span<const std::int32_t> vertices,
                              std::span<const glm::dvec3> positions, const Callbacks& callbacks) {
  require_moves(vertices, positions, followers_->leader_count(points_.size()), fit_.placement);
  std::vector<std::int32_t> movers(vertices.begin(), vertices.end());
  std::vector<glm::dvec3> to(positions.begin(), positions.end());
  followers_->follow(points_, movers, to);
  PastMove before = take_moves(movers, to);
  EditChange change = apply(callbacks);
  if (moved_.empty()) return change;  // no step that could be taken back
  future_.clear();
  past_.add(std::move(before));
  return change;
}

EditChange Editor::Impl::step(MoveHistory& from, MoveHistory& to, const Callbacks& callbacks) {
  if (from.empty()) return {};
  PastMove before = take_moves(from.last().vertices, from.last().positions);
  EditChange change = apply(callbacks);
  from.drop_last();
  to.add(std::move(before));
  return change;
}

EditChange Editor::Impl::settle(const Callbacks& callbacks) {
  const HostScope host(callbacks);
  if (solve_) solve_->settle(callbacks);
  const std::vector<glm::dvec3> state = take_whole_state(callbacks);
  const AdoptedStop unstoppable(nullptr);
  moved_.clear();
  return make_all(state, true);
}

const SurfaceQueries& Editor::Impl::queries() {
  if (!queries_) {
    limit_ = std::make_unique<const LimitSurface>(surface_->surface());
    queries_ = std::make_unique<SurfaceQueries>(*limit_);
  }
  return *queries_;
}

Selection Editor::Impl::select(std::span<const std::int32_t> vertices, double radius) const {
  for (const std::int32_t vertex : vertices) {
    if (vertex >= 0 && vertex < mesh_.vertex_count()) continue;
    throw Error(ErrorCode::InvalidArgument,
                formatted("select: there is no vertex {}; the mesh has 0 to {}", vertex,
                          mesh_.vertex_count() - 1),
                vertex);
  }
  Selection found = select_around(*fit_.prepared, points_, vertices, radius);
  const std::int32_t leaders = followers_->leader_count(points_.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.vertices.size(); ++i) {
    if (found.vertices[i] >= leaders) continue;
    found.vertices[kept] = found.vertices[i];
    found.weights[kept++] = found.weights[i];
  }
  found.vertices.resize(kept);
  found.weights.resize(kept);
  return found;
}

void Editor::Impl::lead(std::span<const AddedVertex> added) {
  followers_ = std::make_shared<Followers>(added, mesh_.positions);
}

PolygonMesh Editor::Impl::mesh() const {
  PolygonMesh result = mesh_;
  result.positions = points_;
  return result;
}

MeasuredError Editor::Impl::measured_error() const {
  return solve_ ? solve_->measured() : fair_->measured(surface_->surface()->state());
}

Fit Editor::Impl::fit() const {
  Fit result = fit_;
  const MeasuredError error = measured_error();
  result.interpolation.error = error.norms;
  if (error.worst >= 0) result.interpolation.worst_vertex = used_.vertices[error.worst];
  result.interpolation.converged = error.norms.max <= options_.fit.tolerance;
  if (!result.interpolation.converged) result.interpolation.stop_reason = StopReason::Stagnated;
  if (fair_) {
    result.fair.emplace();
    const auto state =
        surface_->surface()->state().first(static_cast<std::size_t>(subdivision_->state_size()));
    result.fair->level_one = {{state.begin(), state.end()}, fit_.placement};
    result.fair->decisions = fair_->decisions();
    return result;
  }
  result.cage = mesh();
  const auto control = solve_->control();
  result.interpolation.displacement.resize(control.size());
  for (std::size_t v = 0; v < control.size(); ++v) {
    result.cage.positions[used_.vertices[v]] = fit_.placement.to_model(control[v]);
    result.interpolation.displacement[v] = control[v] - solve_->given()[v];
  }
  return result;
}

// -1 for a vertex that no face names.
std::int32_t Editor::Impl::used_index(std::int32_t vertex) const {
  if (fit_.prepared->uses_all()) return vertex;
  const auto found = std::ranges::lower_bound(used_.vertices, vertex);
  if (found == used_.vertices.end() || *found != vertex) return -1;
  return static_cast<std::int32_t>(found - used_.vertices.begin());
}

// Lists the moves in moved_, local_, targets_, each vertex once; returns where all have been.
PastMove Editor::Impl::take_moves(std::span<const std::int32_t> vertices,
                                  std::span<const glm::dvec3> positions) {
  PastMove before;
  moved_.clear();
  targets_.clear();
  // Of a vertex that is named twice the last counts.
  order_.resize(vertices.size());
  for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<std::int32_t>(i);
  std::ranges::stable_sort(order_, {}, [&](std::int32_t i) { return vertices[i]; });
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const std::int32_t vertex = vertices[order_[i]];
    if (i + 1 < order_.size() && vertices[order_[i + 1]] == vertex) continue;
    moved_.push_back(vertex);
    targets_.push_back(positions[order_[i]]);
  }
  before.vertices = moved_;
  for (const std::int32_t vertex : moved_) before.positions.push_back(points_[vertex]);
  return before;
}

EditChange Editor::Impl::apply(const Callbacks& callbacks) {
  const HostScope host(callbacks);
  local_.clear();
  unit_.clear();
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    const std::int32_t vertex = used_index(moved_[i]);
    if (vertex < 0) continue;
    local_.push_back(vertex);
    unit_.push_back(fit_.placement.to_unit(targets_[i]));
  }
  if (solve_) {
    solve_->move(local_, unit_);
  } else {
    move_fair(callbacks);
  }
  const bool is_whole = is_stale_ || (solve_ ? solve_->changed_all() : !whole_.empty());
  std::vector<glm::dvec3> state;
  if (is_whole) state = take_whole_state({});
  // From here on what is solved becomes the surface, whoever asks to stop.
  const AdoptedStop unstoppable(nullptr);
  is_stale_ = true;
  for (std::size_t i = 0; i < moved_.size(); ++i) points_[moved_[i]] = targets_[i];
  if (is_whole) return make_all(state, false);
  if (solve_) {
    surface_->update(solve_->changed(), solve_->control());
  } else {
    surface_->add_to_state(fair_->places(), fair_->differences());
    bound_ += kFairRounding;
    ++local_moves_;
  }
  control_points_.clear();
  for (const std::int32_t v : solve_ ? solve_->changed() : fair_->vertices())
    control_points_.push_back(used_.vertices[v]);
  return finish(false, true);
}

// A whole net that is cancelled leaves the points where they were.
void Editor::Impl::move_fair(const Callbacks& callbacks) {
  const bool is_due = options_.settle_after > 0 && local_moves_ >= options_.settle_after;
  fair_->move(local_, unit_);
  if (!fair_->is_whole() && !is_stale_ && !is_due) return;
  try {
    whole_ = fair_->whole_state(callbacks);
  } catch (...) {
    for (std::size_t i = 0; i < local_.size(); ++i)
      unit_[i] = fit_.placement.to_unit(points_[used_.vertices[local_[i]]]);
    fair_->put(local_, unit_);
    throw;
  }
}

// Of the fair method, what a move has made, or a net of all points; else nothing.
std::vector<glm::dvec3> Editor::Impl::take_whole_state(const Callbacks& callbacks) {
  std::vector<glm::dvec3> state;
  state.swap(whole_);
  if (fair_ && state.empty()) state = fair_->whole_state(callbacks);
  return state;
}

EditChange Editor::Impl::make_all(std::span<const glm::dvec3> state, bool rebuilds_tree) {
  is_stale_ = true;
  if (solve_) {
    surface_->update_all(solve_->control());
  } else {
    surface_->set_state_all(state);
    bound_ = measured_error().norms.max;
    local_moves_ = 0;
  }
  control_points_.assign(used_.vertices.begin(), used_.vertices.end());
  if (queries_ && rebuilds_tree) queries_->rebuild();
  return finish(true, !rebuilds_tree);
}

EditChange Editor::Impl::finish(bool is_whole, bool refits_tree) {
  EditChange change;
  if (queries_ && refits_tree) change.tree_nodes = queries_->refit(surface_->changed_corners());
  is_stale_ = false;
  change.vertices = moved_;
  change.control_points = control_points_;
  change.rows = surface_->changed_rows();
  for (const RowRange& range : change.rows) change.row_count += range.count;
  change.is_whole = is_whole;
  return change;
}

Editor::Editor(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options) {
  require_editable(mesh, fit, options);
  if (!fit.fair || !fit.fair->sharp_decisions) {
    impl_ = std::make_unique<Impl>(mesh, fit, options);
    return;
  }
  EditorOptions smooth = options;
  smooth.fit.obeys_semi_sharp = false;
  FitOptions again = smooth.fit;
  again.fair_decisions = &fit.fair->decisions;
  again.prepared = fit.prepared;
  impl_ = std::make_unique<Impl>(mesh, planish::fit(mesh, *make_cpu_backend(), again), smooth);
}

Editor::Editor(const FittedMesh& fitted, int level)
    : Editor(fitted, EditorOptions{level, fitted.options}) {}

Editor::Editor(const FittedMesh& fitted, const EditorOptions& options)
    : Editor(fitted.mesh, fitted.fit, options) {
  impl_->lead(fitted.added_vertices);
}

Editor::Editor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Editor::Editor(Editor&& other) noexcept = default;
Editor& Editor::operator=(Editor&& other) noexcept = default;
Editor::~Editor() = default;

EditChange Editor::move(std::span<const std::int32_t> vertices,
                        std::span<const glm::dvec3> positions, const Callbacks& callbacks) {
  return impl_->move(vertices, positions, callbacks);
}

EditChange Editor::transform(const Selection& selection, const glm::dmat4& map,
                             const Callbacks& callbacks) {
  if (selection.vertices.size() != selection.weights.size()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("transform: there are {} vertices and {} weights; give one each",
                          selection.vertices.size(), selection.weights.size()));
  }
  std::vector<glm::dvec3> positions(selection.vertices.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::int32_t vertex = selection.vertices[i];
    if (vertex < 0 || vertex >= std::ssize(points())) continue;  // refused by move()
    const glm::dvec3& from = points()[vertex];
    const glm::dvec3 to(map * glm::dvec4(from, 1.0));
    positions[i] = from + selection.weights[i] * (to - from);
  }
  return move(selection.vertices, positions, callbacks);
}

Selection Editor::select(std::span<const std::int32_t> vertices, double radius) const {
  return impl_->select(vertices, radius);
}

EditChange Editor::set_sharp(std::span<const CreaseEdge> edges,
                             std::span<const CornerVertex> corners, const Callbacks& callbacks) {
  *this = with_sharp(edges, corners, callbacks);
  return everything();
}

Editor Editor::with_sharp(std::span<const CreaseEdge> edges, std::span<const CornerVertex> corners,
                          const Callbacks& callbacks) const {
  return Editor(impl_->with_sharp(edges, corners, callbacks));
}

EditChange Editor::everything() { return impl_->all_rows(); }

EditChange Editor::undo(const Callbacks& callbacks) {
  return impl_->step(impl_->past(), impl_->future(), callbacks);
}
EditChange Editor::redo(const Callbacks& callbacks) {
  return impl_->step(impl_->future(), impl_->past(), callbacks);
}
bool Editor::can_undo() const { return !impl_->past().empty(); }
bool Editor::can_redo() const { return !impl_->future().empty(); }

EditChange Editor::settle(const Callbacks& callbacks) { return impl_->settle(callbacks); }

EditChange Editor::refit(const Callbacks& callbacks) {
  *this = refitted(callbacks);
  return everything();
}

Editor Editor::refitted(const Callbacks& callbacks) const {
  return Editor(impl_->refitted(callbacks));
}

std::span<const glm::dvec3> Editor::points() const { return impl_->points(); }
std::span<const glm::dvec3> Editor::rest_positions() const { return impl_->rest_positions(); }
double Editor::error_bound() const { return impl_->error_bound(); }
double Editor::measured_error() const { return impl_->measured_error().norms.max; }
std::span<const glm::dvec3> Editor::positions() const { return impl_->surface().positions(); }
std::span<const glm::vec3> Editor::normals() const { return impl_->surface().normals(); }
PolygonMesh Editor::mesh() const { return impl_->mesh(); }
Fit Editor::fit() const { return impl_->fit(); }
const SurfaceQueries& Editor::queries() { return impl_->queries(); }
std::unique_ptr<SurfaceBlocks> Editor::blocks(int level) const {
  return impl_->surface().surface()->level(level);
}

namespace {

bool has_tags_of(const PolygonMesh& a, const PolygonMesh& b) {
  return std::ranges::equal(a.creases, b.creases,
                            [](const CreaseEdge& x, const CreaseEdge& y) {
                              return x.v0 == y.v0 && x.v1 == y.v1 && x.sharpness == y.sharpness;
                            }) &&
         std::ranges::equal(a.corners, b.corners, [](const CornerVertex& x, const CornerVertex& y) {
           return x.vertex == y.vertex && x.sharpness == y.sharpness;
         });
}

}  // namespace

FittedMesh edited(const FittedMesh& first, const Editor& editor) {
  FittedMesh result = first;
  const auto rest = editor.rest_positions();
  result.mesh = editor.mesh();
  result.fit = editor.fit();
  result.rest_positions.assign(rest.begin(), rest.end());
  if (!has_tags_of(result.mesh, first.mesh)) {
    // What is sharp was set by hand: no rule of the first fit finds it again.
    result.uses_tags = true;
    result.split_normals = false;
    result.finds_features = false;
    result.crease_degrees.reset();
    result.found = {};
  }
  // What was measured was the surface before the moves.
  result.level_one_quality.reset();
  return result;
}

}  // namespace planish
