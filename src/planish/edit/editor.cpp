#include "planish/edit/editor.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/edit/edited_surface.h"
#include "planish/edit/local_fair.h"
#include "planish/edit/local_solve.h"
#include "planish/edit/require_editable.h"
#include "planish/pipeline/limit_system.h"

namespace planish {

namespace {

// Farther off, coordinates of unit diagonal lose what the tolerance asks for.
constexpr double kFarthestMove = 1e6;

// What a centroid of a dozen points may be off by after differences have been added to these.
constexpr double kFairRounding = 4e-16;

// Meshes whose positions undo and redo keep each.
constexpr std::size_t kMostPast = 4;

// Vertices and where they were before a move.
struct PastMove {
  std::vector<std::int32_t> vertices;
  std::vector<glm::dvec3> positions;
};

}  // namespace

class Editor::Impl {
 public:
  Impl(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options)
      : mesh_(mesh),
        options_(options),
        fit_(copy_without_arrays(fit)),
        points_(mesh.positions),
        used_(used_part(mesh, fit.prepared)) {
    options_.fit.callbacks = {};
    const auto unit = [&](const std::vector<glm::dvec3>& positions) {
      std::vector<glm::dvec3> result(used_.vertices.size());
      parallel_each(result.size(), [&](std::size_t v) {
        result[v] = fit_.placement.to_unit(positions[static_cast<std::size_t>(used_.vertices[v])]);
      });
      return result;
    };
    features_ = find_sharp_features(used_.mesh, *fit.prepared->topology, used_.mesh.positions,
                                    options.fit.sharp);
    // A fair net's first step takes the weights of 1978 whatever the later levels take.
    subdivision_.emplace(*fit.prepared->topology, features_,
                         fit.fair ? Weights::DooSabin : options.fit.weights);
    if (fit.fair) {
      fair_.emplace(used_.mesh, *subdivision_, fit.fair->decisions, options.fit.polish_steps,
                    options.fit.cures_folds, unit(mesh.positions));
    } else {
      solve_.emplace(doo_sabin_system(used_.mesh, *subdivision_, options_.fit),
                     fit.prepared->topology, unit(mesh.positions), unit(fit.cage.positions),
                     options.fit.tolerance);
    }
    EvaluateOptions evaluate;
    evaluate.level = options.level;
    evaluate.weights = options.fit.weights;
    evaluate.sharp = options.fit.sharp;
    evaluate.rest_positions = mesh.positions;
    evaluate.prepared = fit.prepared;
    surface_.emplace(mesh, fit_.placement,
                     solve_ ? solve_->control() : std::span<const glm::dvec3>{},
                     fit.fair ? std::span<const glm::dvec3>(fit.fair->level_one.state)
                              : std::span<const glm::dvec3>{},
                     evaluate);
    bound_ = fit.interpolation.error.max;
  }

  EditChange move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> positions,
                  const Callbacks& callbacks) {
    require_moves(vertices, positions);
    PastMove before = take_moves(vertices, positions);
    EditChange change = apply(callbacks);
    future_.clear();
    remember(past_, std::move(before));
    return change;
  }

  // One way through the moves that were made.
  EditChange step(std::deque<PastMove>& from, std::deque<PastMove>& to,
                  const Callbacks& callbacks) {
    if (from.empty()) return {};
    PastMove before = take_moves(from.back().vertices, from.back().positions);
    EditChange change = apply(callbacks);
    from.pop_back();
    remember(to, std::move(before));
    return change;
  }

  EditChange settle(const Callbacks& callbacks) {
    const HostScope host(callbacks);
    if (solve_) solve_->settle(callbacks);
    EditChange change = whole_change(callbacks);
    moved_.clear();
    change.vertices = {};
    return change;
  }

  [[nodiscard]] Selection select(std::span<const std::int32_t> vertices, double radius) const {
    for (const std::int32_t vertex : vertices) {
      if (vertex >= 0 && vertex < mesh_.vertex_count()) continue;
      throw Error(ErrorCode::InvalidArgument,
                  "select: there is no vertex " + std::to_string(vertex) + "; the mesh has 0 to " +
                      std::to_string(mesh_.vertex_count() - 1),
                  vertex);
    }
    return select_around(*fit_.prepared, points_, vertices, radius);
  }

  [[nodiscard]] PolygonMesh mesh() const {
    PolygonMesh result = mesh_;
    result.positions = points_;
    return result;
  }

  [[nodiscard]] Fit fit() const {
    Fit result = fit_;
    if (fair_) {
      result.fair.emplace();
      const auto state =
          surface_->surface()->state().first(static_cast<std::size_t>(subdivision_->state_size()));
      result.fair->level_one = {{state.begin(), state.end()}, fit_.placement};
      result.fair->decisions = fair_->decisions();
      result.interpolation.error.max = measured_error();
      return result;
    }
    result.cage = mesh();
    const auto control = solve_->control();
    result.interpolation.displacement.resize(control.size());
    for (std::size_t v = 0; v < control.size(); ++v) {
      result.cage.positions[static_cast<std::size_t>(used_.vertices[v])] =
          fit_.placement.to_model(control[v]);
      result.interpolation.displacement[v] = control[v] - solve_->given()[v];
    }
    result.interpolation.error.max = solve_->measured();
    return result;
  }

  [[nodiscard]] double error_bound() const { return solve_ ? solve_->bound() : bound_; }
  [[nodiscard]] double measured_error() const {
    return solve_ ? solve_->measured() : fair_->measured(surface_->surface()->state());
  }

  const PolygonMesh& mesh_;
  EditorOptions options_;
  Fit fit_;  // without its arrays
  std::vector<glm::dvec3> points_;
  UsedPart used_;
  SharpFeatures features_;
  std::optional<Subdivision> subdivision_;
  std::optional<LocalSolve> solve_;  // of the progressive method
  std::optional<LocalFair> fair_;    // of the other
  std::optional<EditedSurface> surface_;
  std::deque<PastMove> past_, future_;

 private:
  static Fit copy_without_arrays(const Fit& fit) {
    Fit result;
    result.interpolation.converged = true;
    result.interpolation.iterations = fit.interpolation.iterations;
    result.placement = fit.placement;
    result.prepared = fit.prepared;
    result.spectral_bound = fit.spectral_bound;
    result.stencil_entries = fit.stencil_entries;
    result.sharp_edge_count = fit.sharp_edge_count;
    result.boundary_edge_count = fit.boundary_edge_count;
    result.corner_count = fit.corner_count;
    return result;
  }

  // No more moves than asked for, and no more positions than a few meshes have.
  void remember(std::deque<PastMove>& list, PastMove&& move) const {
    const auto most = static_cast<std::size_t>(std::max(options_.undo_steps, 0));
    list.push_back(std::move(move));
    std::size_t positions = 0;
    for (const PastMove& past : list) positions += past.vertices.size();
    while (list.size() > most || (list.size() > 1 && positions > kMostPast * points_.size())) {
      positions -= list.front().vertices.size();
      list.pop_front();
    }
  }

  // -1 for a vertex that no face names.
  [[nodiscard]] std::int32_t used_index(std::int32_t vertex) const {
    if (fit_.prepared->uses_all()) return vertex;
    const auto found = std::ranges::lower_bound(used_.vertices, vertex);
    if (found == used_.vertices.end() || *found != vertex) return -1;
    return static_cast<std::int32_t>(found - used_.vertices.begin());
  }

  void require_moves(std::span<const std::int32_t> vertices,
                     std::span<const glm::dvec3> positions) const {
    if (vertices.size() != positions.size()) {
      throw Error(ErrorCode::InvalidArgument, "move: there are " + std::to_string(vertices.size()) +
                                                  " vertices and " +
                                                  std::to_string(positions.size()) + " positions");
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto name = [&] { return "move " + std::to_string(i) + ": "; };
      if (vertices[i] < 0 || vertices[i] >= mesh_.vertex_count()) {
        throw Error(ErrorCode::InvalidArgument,
                    name() + "there is no vertex " + std::to_string(vertices[i]) +
                        "; the mesh has 0 to " + std::to_string(mesh_.vertex_count() - 1),
                    vertices[i]);
      }
      const glm::dvec3 unit = fit_.placement.to_unit(positions[i]);
      const double far = std::max({std::abs(unit.x), std::abs(unit.y), std::abs(unit.z)});
      if (far <= kFarthestMove && !std::isnan(unit.x + unit.y + unit.z)) continue;
      throw Error(ErrorCode::InvalidArgument,
                  name() + "the position of vertex " + std::to_string(vertices[i]) +
                      " is not finite or farther than 10^6 diagonals off; fit the moved mesh anew",
                  vertices[i]);
    }
  }

  // Lists the moves in moved_, local_, targets_, each vertex once; returns where all have been.
  PastMove take_moves(std::span<const std::int32_t> vertices,
                      std::span<const glm::dvec3> positions) {
    PastMove before;
    moved_.clear();
    targets_.clear();
    // From behind, so that the last one comes first and the others are passed by.
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

  EditChange apply(const Callbacks& callbacks) {
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
    for (std::size_t i = 0; i < moved_.size(); ++i)
      points_[static_cast<std::size_t>(moved_[i])] = targets_[i];
    if (solve_ ? solve_->changed_all() : fair_->is_whole()) return whole_change();
    if (solve_) {
      surface_->update(solve_->changed(), solve_->control());
    } else {
      surface_->add_to_state(fair_->places(), fair_->differences());
      bound_ += kFairRounding;
    }
    control_points_.clear();
    for (const std::int32_t v : solve_ ? solve_->changed() : fair_->vertices())
      control_points_.push_back(used_.vertices[static_cast<std::size_t>(v)]);
    return change_of(false);
  }

  // A whole net that is cancelled leaves the points where they were.
  void move_fair(const Callbacks& callbacks) {
    fair_->move(local_, unit_);
    if (!fair_->is_whole()) return;
    try {
      whole_ = fair_->whole_state(callbacks);
    } catch (...) {
      for (std::size_t i = 0; i < local_.size(); ++i)
        unit_[i] = fit_.placement.to_unit(
            points_[static_cast<std::size_t>(used_.vertices[static_cast<std::size_t>(local_[i])])]);
      fair_->put(local_, unit_);
      throw;
    }
  }

  EditChange whole_change(const Callbacks& callbacks = {}) {
    if (solve_) {
      surface_->update_all(solve_->control());
    } else {
      if (whole_.empty()) whole_ = fair_->whole_state(callbacks);
      surface_->set_state_all(whole_);
      whole_ = {};
      bound_ = measured_error();
    }
    control_points_.assign(used_.vertices.begin(), used_.vertices.end());
    return change_of(true);
  }

  EditChange change_of(bool is_whole) const {
    EditChange change;
    change.vertices = moved_;
    change.control_points = control_points_;
    change.rows = surface_->changed_rows();
    for (const RowRange& range : change.rows) change.row_count += range.count;
    change.is_whole = is_whole;
    return change;
  }

  double bound_ = 0;  // of the fair method
  std::vector<glm::dvec3> whole_;
  std::vector<std::int32_t> moved_, local_, control_points_, order_;
  std::vector<glm::dvec3> targets_, unit_;
};

Editor::Editor(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options) {
  require_editable(mesh, fit, options);
  impl_ = std::make_unique<Impl>(mesh, fit, options);
}

Editor::Editor(const FittedMesh& fitted, int level)
    : Editor(fitted.mesh, fitted.fit, {level, fitted.options}) {}

Editor::~Editor() = default;

EditChange Editor::move(std::span<const std::int32_t> vertices,
                        std::span<const glm::dvec3> positions, const Callbacks& callbacks) {
  return impl_->move(vertices, positions, callbacks);
}

EditChange Editor::transform(const Selection& selection, const glm::dmat4& map,
                             const Callbacks& callbacks) {
  if (selection.vertices.size() != selection.weights.size()) {
    throw Error(ErrorCode::InvalidArgument,
                "transform: there are " + std::to_string(selection.vertices.size()) +
                    " vertices and " + std::to_string(selection.weights.size()) + " weights");
  }
  std::vector<glm::dvec3> positions(selection.vertices.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::int32_t vertex = selection.vertices[i];
    if (vertex < 0 || vertex >= impl_->mesh_.vertex_count()) continue;  // refused by move()
    const glm::dvec3& from = impl_->points_[static_cast<std::size_t>(vertex)];
    const glm::dvec3 to(map * glm::dvec4(from, 1.0));
    positions[i] = from + selection.weights[i] * (to - from);
  }
  return move(selection.vertices, positions, callbacks);
}

Selection Editor::select(std::span<const std::int32_t> vertices, double radius) const {
  return impl_->select(vertices, radius);
}

EditChange Editor::undo(const Callbacks& callbacks) {
  return impl_->step(impl_->past_, impl_->future_, callbacks);
}
EditChange Editor::redo(const Callbacks& callbacks) {
  return impl_->step(impl_->future_, impl_->past_, callbacks);
}
bool Editor::can_undo() const { return !impl_->past_.empty(); }
bool Editor::can_redo() const { return !impl_->future_.empty(); }

EditChange Editor::settle(const Callbacks& callbacks) { return impl_->settle(callbacks); }

std::span<const glm::dvec3> Editor::points() const { return impl_->points_; }
double Editor::error_bound() const { return impl_->error_bound(); }
double Editor::measured_error() const { return impl_->measured_error(); }
std::span<const glm::dvec3> Editor::positions() const { return impl_->surface_->positions(); }
std::span<const glm::vec3> Editor::normals() const { return impl_->surface_->normals(); }
PolygonMesh Editor::mesh() const { return impl_->mesh(); }
Fit Editor::fit() const { return impl_->fit(); }
std::unique_ptr<SurfaceBlocks> Editor::blocks(int level) const {
  return impl_->surface_->surface()->level(level);
}

}  // namespace planish
