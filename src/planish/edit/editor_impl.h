#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planish/edit/edited_surface.h"
#include "planish/edit/editor.h"
#include "planish/edit/followers.h"
#include "planish/edit/local_fair.h"
#include "planish/edit/local_solve.h"
#include "planish/edit/measured_error.h"
#include "planish/edit/move_history.h"

namespace planish {

/// The way of a move: solve, surface, change.
class Editor::Impl {
 public:
  Impl(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options,
       const Callbacks& callbacks = {});
  /// The same of a mesh that it keeps.
  Impl(std::unique_ptr<const PolygonMesh> mesh, const Fit& fit, const EditorOptions& options,
       const Callbacks& callbacks);

  /// Another one, of the mesh as it is now with other tags. Throws as Editor::set_sharp().
  [[nodiscard]] std::unique_ptr<Impl> with_sharp(std::span<const CreaseEdge> edges,
                                                 std::span<const CornerVertex> corners,
                                                 const Callbacks& callbacks) const;
  /// Another one, of the mesh as it is now. Throws as Editor::refit().
  [[nodiscard]] std::unique_ptr<Impl> refitted(const Callbacks& callbacks) const;
  /// That all is new.
  EditChange all_rows();

  EditChange move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> positions,
                  const Callbacks& callbacks);
  /// One way through the moves that were made.
  EditChange step(MoveHistory& from, MoveHistory& to, const Callbacks& callbacks);
  EditChange settle(const Callbacks& callbacks);
  /// The last vertices of the mesh go with the others from now on.
  void lead(std::span<const AddedVertex> added);

  [[nodiscard]] Selection select(std::span<const std::int32_t> vertices, double radius) const;
  [[nodiscard]] PolygonMesh mesh() const;
  [[nodiscard]] Fit fit() const;
  [[nodiscard]] std::span<const glm::dvec3> points() const { return points_; }
  [[nodiscard]] std::span<const glm::dvec3> rest_positions() const { return mesh_.positions; }
  [[nodiscard]] const EditedSurface& surface() const { return *surface_; }
  [[nodiscard]] double error_bound() const { return solve_ ? solve_->bound() : bound_; }
  [[nodiscard]] MeasuredError measured_error() const;
  [[nodiscard]] const SurfaceQueries& queries();
  [[nodiscard]] MoveHistory& past() { return past_; }
  [[nodiscard]] MoveHistory& future() { return future_; }

 private:
  [[nodiscard]] Fit fit_anew(const PolygonMesh& mesh, const Callbacks& callbacks) const;
  [[nodiscard]] std::unique_ptr<Impl> next(std::unique_ptr<const PolygonMesh> mesh, const Fit& fit,
                                           const Callbacks& callbacks) const;
  [[nodiscard]] std::int32_t used_index(std::int32_t vertex) const;
  [[nodiscard]] PastMove take_moves(std::span<const std::int32_t> vertices,
                                    std::span<const glm::dvec3> positions);
  EditChange apply(const Callbacks& callbacks);
  void move_fair(const Callbacks& callbacks);
  [[nodiscard]] std::vector<glm::dvec3> take_whole_state(const Callbacks& callbacks);
  EditChange make_all(std::span<const glm::dvec3> state, bool rebuilds_tree);
  EditChange finish(bool is_whole, bool refits_tree);

  std::unique_ptr<const PolygonMesh> own_mesh_;
  const PolygonMesh& mesh_;
  EditorOptions options_;
  Fit fit_;  // without its arrays
  std::vector<glm::dvec3> points_;
  UsedPart used_;
  std::shared_ptr<const Followers> followers_ = std::make_shared<Followers>();
  std::optional<Subdivision> subdivision_;
  std::optional<LocalSolve> solve_;  // of the progressive method
  std::optional<LocalFair> fair_;    // of the other
  std::optional<EditedSurface> surface_;
  std::unique_ptr<const LimitSurface> limit_;  // of queries_
  std::unique_ptr<SurfaceQueries> queries_;    // once they are asked for
  MoveHistory past_, future_;

  double bound_ = 0;       // of the fair method
  int local_moves_ = 0;    // of it, since the whole net was made
  bool is_stale_ = false;  // memory ran out between a solve and its rows
  std::vector<glm::dvec3> whole_;
  std::vector<std::int32_t> moved_, local_, control_points_, order_;
  std::vector<glm::dvec3> targets_, unit_;
};

}  // namespace planish
