#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/doosabin/subdivision.h"
#include "planish/edit/editor.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_surface.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/refine/refine_mesh.h"
#include "planish/solve/backend.h"
#include "planish/solve/progressive.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

/// Some of the numbers 0 to size - 1 in the order in which they came, for loops whose cost follows
/// what is in it, not `size`: it is emptied at no cost. 4 bytes a number. Source: Briggs & Torczon,
/// "An efficient representation for sparse sets", 1993.
class SparseSet {
 public:
  explicit SparseSet(std::int32_t size) : places_(static_cast<std::size_t>(size), 0) {}

  void clear() { members_.clear(); }
  [[nodiscard]] bool contains(std::int32_t number) const {
    const auto place = static_cast<std::size_t>(places_[number]);
    return place < members_.size() && members_[place] == number;
  }
  /// Where the number stands among members(); it must be there.
  [[nodiscard]] std::size_t place_of(std::int32_t number) const {
    return static_cast<std::size_t>(places_[number]);
  }
  /// False where it was there already.
  bool add(std::int32_t number) {
    if (contains(number)) return false;
    places_[number] = static_cast<std::int32_t>(members_.size());
    members_.push_back(number);
    return true;
  }
  [[nodiscard]] std::span<const std::int32_t> members() const { return members_; }

 private:
  std::vector<std::int32_t> places_, members_;
};

/// How far a surface is from the points that it passes through, and from which of them the most.
struct MeasuredError {
  ErrorNorms norms;
  std::int64_t worst = -1;
};

/// Of `residual(i)` for i below `count`, summed in a fixed order.
template <class Residual>
[[nodiscard]] MeasuredError measure_error(std::size_t count, const Residual& residual) {
  constexpr std::size_t kGrain = 4096;
  struct Sum {
    double largest = -1, squares = 0;
    std::int64_t worst = -1;
  };
  const Sum all = ordered_reduce(
      count, kGrain, Sum{},
      [&](std::size_t begin, std::size_t end) {
        Sum sum;
        for (std::size_t i = begin; i < end; ++i) {
          const auto r = residual(i);
          const double square = glm::dot(r, r);
          sum.squares += square;
          if (!(square > sum.largest)) continue;
          sum.largest = square;
          sum.worst = static_cast<std::int64_t>(i);
        }
        return sum;
      },
      [](Sum& total, const Sum& piece) {
        total.squares += piece.squares;
        if (!(piece.largest > total.largest)) return;
        total.largest = piece.largest;
        total.worst = piece.worst;
      });
  MeasuredError result;
  if (count == 0) return result;
  result.norms = {std::sqrt(std::max(all.largest, 0.0)),
                  std::sqrt(all.squares / static_cast<double>(count))};
  result.worst = all.worst;
  return result;
}

/// The system B P = V0 while points of V0 move: rows are solved where their residual is too large
/// and nowhere else. Every residual is at most bound() after every call, however many there were:
/// a row is looked at again whenever a control point that it names has moved. All in coordinates of
/// unit diagonal. Not for several threads at once.
class LocalSolve {
 public:
  /// `control` solves the system for `given` as nearly as a fit left it. Solves on to `tolerance`
  /// and beyond, so that moves begin with room. Throws Error{InvalidArgument} where that does not
  /// converge, Error{Cancelled}.
  LocalSolve(LimitSystem system, std::shared_ptr<const MeshTopology> topology,
             std::vector<glm::dvec3> given, std::vector<glm::dvec3> control, double tolerance,
             const Callbacks& callbacks = {});

  [[nodiscard]] std::span<const glm::dvec3> given() const { return given_; }
  [[nodiscard]] std::span<const glm::dvec3> control() const { return control_; }
  /// No row's residual is longer.
  [[nodiscard]] double bound() const { return bound_; }

  /// Vertices to their new points, none twice. The control points that changed are changed()
  /// afterwards. Throws Error{Cancelled}, and all is as it was.
  void move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points);
  /// The vertices whose control points the last call changed, or that it moved, in any order.
  [[nodiscard]] std::span<const std::int32_t> changed() const { return touched_.members(); }
  /// Rows that the last move looked at: what it cost.
  [[nodiscard]] std::int64_t row_count() const { return row_count_; }
  /// Whether changed() names too many to be worth it: all may have changed.
  [[nodiscard]] bool changed_all() const { return changed_all_; }

  /// A solve of all rows, from where they are. Throws as the constructor, and all is as it was.
  void settle(const Callbacks& callbacks = {});
  /// The residuals of all rows, measured in double.
  [[nodiscard]] MeasuredError measured() const;

 private:
  [[nodiscard]] glm::dvec3 residual(std::int32_t row) const;
  void touch(std::int32_t vertex);
  void wake(std::int32_t vertex);
  void shift(std::int32_t vertex, const glm::dvec3& step);
  void refresh_sums_at(std::int32_t vertex);
  [[nodiscard]] std::int32_t first_sum_of(std::int32_t face) const;
  [[nodiscard]] std::size_t most_touched() const;
  [[nodiscard]] bool reaches_many(std::span<const std::int32_t> vertices,
                                  std::span<const glm::dvec3> points);
  bool relax();
  void take_back();

  LimitSystem system_;
  std::shared_ptr<const MeshTopology> topology_;
  std::vector<glm::dvec3> given_, control_;
  RawVector<glm::dvec3> sums_;             // of large faces
  std::vector<std::int32_t> large_faces_;  // ascending
  std::int32_t sums_per_face_ = 0;
  double tolerance_, bound_ = 0;

  SparseSet touched_;
  struct Before {
    glm::dvec3 given, control;
  };
  std::vector<Before> before_;                    // of touched_'s members
  std::vector<std::vector<std::int32_t>> rings_;  // of reaches_many()
  SparseSet fresh_faces_;                         // large ones whose sums this move has made anew
  std::vector<std::int32_t> queue_;
  std::vector<std::uint8_t> is_queued_;
  std::int64_t row_count_ = 0;
  bool changed_all_ = false;
};

/// A fair net while given points move: some rings of faces around these make nets of their own,
/// before and after the move, by the decisions of the whole net, and the control points change by
/// the difference. Each polygon keeps its centroid, so that the surface passes through every point
/// to rounding. In coordinates of unit diagonal. Not for several threads at once.
class LocalFair {
 public:
  /// Of a fair fit; `mesh` has no unused vertices, and all of it must outlive this.
  LocalFair(const PolygonMesh& mesh, const Subdivision& subdivision, FairDecisions decisions,
            std::int32_t polish_steps, bool cures_folds, std::vector<glm::dvec3> given);

  /// Vertices to their new points, none twice. Throws Error{Cancelled}, and all is as it was.
  void move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points);
  /// Puts points where they are, and nothing more.
  void put(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points);
  /// After a move: places of the state that change and by how much, and the vertices that they
  /// belong to; or is_whole(), and the state is to be made anew.
  [[nodiscard]] std::span<const std::int32_t> places() const { return places_; }
  [[nodiscard]] std::span<const glm::dvec3> differences() const { return differences_; }
  [[nodiscard]] std::span<const std::int32_t> vertices() const { return changed_; }
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  /// The state of all of the mesh. Throws Error{Cancelled}.
  [[nodiscard]] std::vector<glm::dvec3> whole_state(const Callbacks& callbacks) const;

  [[nodiscard]] std::span<const glm::dvec3> given() const { return given_; }
  [[nodiscard]] const FairDecisions& decisions() const { return decisions_; }
  /// The ways from given points to the surface's, of a state of level 1.
  [[nodiscard]] MeasuredError measured(std::span<const glm::dvec3> state) const;

 private:
  class Part;

  void grow(std::span<const std::int32_t> vertices);

  const PolygonMesh& mesh_;
  const Subdivision& subdivision_;
  FairDecisions decisions_;
  std::int32_t polish_steps_;
  bool cures_folds_;
  std::vector<glm::dvec3> given_;

  SparseSet near_;               // vertices whose faces are the part
  std::size_t inner_count_ = 0;  // those of them whose control points may change
  SparseSet faces_;
  std::vector<std::int32_t> places_, changed_;
  std::vector<glm::dvec3> differences_;
  bool is_whole_ = false;
};

/// A Doo-Sabin surface whose control points of level 1 change here and there, with the rows of one
/// level kept up to date. Vertices and faces are those of the mesh without unused vertices. Not for
/// several threads at once.
class EditedSurface {
 public:
  /// Of a cage in unit coordinates, or of a state of level 1 where that is not empty. `mesh` and
  /// what `options` refer to must outlive it. Throws as DooSabinSurface, Error{OutOfMemory}.
  EditedSurface(const PolygonMesh& mesh, const Placement& placement,
                std::span<const glm::dvec3> cage, std::span<const glm::dvec3> state,
                const EvaluateOptions& options);

  [[nodiscard]] const std::shared_ptr<DooSabinSurface>& surface() const { return surface_; }
  [[nodiscard]] std::span<const glm::dvec3> positions() const { return positions_; }
  [[nodiscard]] std::span<const glm::vec3> normals() const { return normals_; }

  /// After control points of the cage have changed at some vertices.
  void update(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> cage);
  /// After they have changed anywhere.
  void update_all(std::span<const glm::dvec3> cage);
  /// Moves points of level 1, by their places in the state. Where one on a curve moves, or a corner
  /// vertex, those of the faces around its vertex do, too.
  void add_to_state(std::span<const std::int32_t> places, std::span<const glm::dvec3> differences);
  void set_state_all(std::span<const glm::dvec3> state);

  /// What the last update has changed: rows ascending, and corners whose patches are others.
  [[nodiscard]] std::span<const RowRange> changed_rows() const { return ranges_; }
  [[nodiscard]] std::span<const std::int32_t> changed_corners() const { return corners_; }

 private:
  void touch_faces_at(std::int32_t vertex);
  void list_faces_around();
  void list_rows();
  void make_rows();
  void follow_touched();
  void make_all_rows();

  std::shared_ptr<DooSabinSurface> surface_;
  PatchSurface patches_;
  FaceWeights weights_;
  RawVector<glm::dvec3> positions_;
  RawVector<glm::vec3> normals_;

  SparseSet touched_;  // faces with other control points
  SparseSet around_;   // and those around their vertices: patches are others there
  std::vector<std::int32_t> faces_, corners_, points_, rows_;
  std::vector<RowRange> ranges_;
};

/// The vertices that refine_mesh() added: each keeps its way from the place that its weights give
/// it among the given ones, wherever these go.
class Followers {
 public:
  Followers() = default;
  /// `positions`: of the mesh that was fitted; the last are those of `added`.
  Followers(std::span<const AddedVertex> added, std::span<const glm::dvec3> positions);

  /// The vertices before them.
  [[nodiscard]] std::int32_t leader_count(std::size_t vertex_count) const {
    return static_cast<std::int32_t>(vertex_count - added_.size());
  }
  /// Adds to moves of given vertices those of all that follow them. `positions`: of all vertices
  /// before the moves.
  void follow(std::span<const glm::dvec3> positions, std::vector<std::int32_t>& vertices,
              std::vector<glm::dvec3>& to) const;
  [[nodiscard]] bool empty() const { return added_.empty(); }

 private:
  std::vector<AddedVertex> added_;
  std::vector<glm::dvec3> offsets_;            // from the mean of its three
  std::vector<std::int32_t> starts_, led_by_;  // of each given vertex, whom it leads
};

/// Vertices, none twice, and where they were before a move.
struct PastMove {
  std::vector<std::int32_t> vertices;
  std::vector<glm::dvec3> positions;
};

/// Moves that can be taken back, the last one at the end: so many, and no more positions than a few
/// meshes have; older ones are forgotten.
class MoveHistory {
 public:
  MoveHistory(int most_moves, std::size_t vertex_count)
      : most_moves_(static_cast<std::size_t>(std::max(most_moves, 0))),
        most_positions_(kMostMeshes * vertex_count) {}

  [[nodiscard]] bool empty() const { return moves_.empty(); }
  [[nodiscard]] const PastMove& last() const { return moves_.back(); }
  void drop_last() {
    positions_ -= moves_.back().vertices.size();
    moves_.pop_back();
  }
  void clear() {
    moves_.clear();
    positions_ = 0;
  }
  void add(PastMove&& move) {
    positions_ += move.vertices.size();
    moves_.push_back(std::move(move));
    while (moves_.size() > most_moves_ || (moves_.size() > 1 && positions_ > most_positions_)) {
      positions_ -= moves_.front().vertices.size();
      moves_.pop_front();
    }
  }

 private:
  static constexpr std::size_t kMostMeshes = 4;

  std::size_t most_moves_, most_positions_, positions_ = 0;
  std::deque<PastMove> moves_;
};

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
