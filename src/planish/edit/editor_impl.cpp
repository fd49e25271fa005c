#include "planish/edit/editor_impl.h"

#include <algorithm>
#include <string>
#include <utility>

#include "planish/backend/cpu_backend.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/core/stop.h"
#include "planish/edit/require_editable.h"
#include "planish/edit/tag_sharp.h"
#include "planish/pipeline/limit_system.h"

namespace planish {

namespace {

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

}  // namespace planish
