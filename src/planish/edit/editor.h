#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/queries/surface_queries.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Vertices that move together, each by its share of the move.
struct Selection {
  std::vector<std::int32_t> vertices;
  std::vector<double> weights;  ///< one a vertex, 0 to 1
};

/// The vertices within `radius` of some others, by the shortest way along edges, so that a sheet
/// nearby does not come along. Weights fall smoothly from 1 there to 0 at the radius:
/// (1 - (d / radius)^2)^2. Costs what it finds. Throws Error{InvalidArgument} for a radius that is
/// not above 0 or not finite.
/// `vertices` and the result are of the mesh that was prepared, `positions` its.
[[nodiscard]] Selection select_around(const PreparedMesh& prepared,
                                      std::span<const glm::dvec3> positions,
                                      std::span<const std::int32_t> vertices, double radius);

struct EditorOptions {
  int level = 2;        ///< of the rows that are kept, 0 to kMaxLevel
  FitOptions fit;       ///< those of the fit: scheme, weights, tolerance, sharp, polish_steps
  int undo_steps = 64;  ///< moves that can be taken back, 0: none; older ones are forgotten
  /// Of the fair method: after so many moves the next one makes the whole net, as settle() does, so
  /// that what the polish of parts leaves does not add up. 0: never.
  int settle_after = 4096;
};

/// What a move has changed. Spans hold until the editor's next call.
struct EditChange {
  std::span<const std::int32_t> vertices;  ///< of the mesh, that moved
  /// Vertices of the mesh whose control points moved along, in any order; of the fair method those
  /// around which control points of level 1 did.
  std::span<const std::int32_t> control_points;
  std::span<const RowRange> rows;  ///< ascending; no other row has other bits than before
  std::int64_t row_count = 0;      ///< in all ranges
  std::int64_t tree_nodes = 0;     ///< of queries(), that were looked at
  bool is_whole = false;           ///< the mesh was solved and evaluated whole
};

/// A fitted mesh whose vertices move: only what they reach is solved and evaluated again, so that a
/// move costs what it moves, not the size of the mesh. The surface passes through all vertices
/// within the fit's tolerance after any number of moves. Control points of a progressive fit are
/// within a small factor of it of those of a fit from scratch by the same decisions; those of a
/// fair one differ by what its polish does far off, until settle() (edit/README.md) or
/// EditorOptions::settle_after moves. Corner sectors and the fair method's decisions (what turns
/// over, is halved, cured) are those of the fit while vertices are moved, so that nothing pops:
/// after large moves a fit of the mesh as it is now decides otherwise. refit() does, too.
///
/// Where memory runs out within a call (Error{OutOfMemory}, std::bad_alloc), the vertices may have
/// moved; the next call makes all rows.
///
/// One thread at a time changes it. Constant functions, and what they return, may be used from many
/// threads while none does.
class Editor {
 public:
  /// `fit` is of `mesh`, which must outlive the editor; its positions are copied. Throws
  /// Error{InvalidArgument} for a fit that has not reached its tolerance, was allowed to leave the
  /// vertices (`within`) or is of another scheme than Doo-Sabin, Error{OutOfMemory}. Semi-sharp
  /// edges are smooth while a mesh is edited: whole fits alone have their rules.
  Editor(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options = {});
  /// The same of all that fit_mesh() made. Vertices that it added are moved along with the given
  /// ones around, by the same weights, and by nothing else.
  explicit Editor(const FittedMesh& fitted, int level = 2);
  Editor(const FittedMesh& fitted, const EditorOptions& options);
  Editor(PolygonMesh&& mesh, const Fit& fit, const EditorOptions& options = {}) = delete;
  Editor(Editor&& other) noexcept;
  Editor& operator=(Editor&& other) noexcept;
  ~Editor();

  /// Moves vertices of the mesh to positions in its coordinates; of a vertex that is named twice
  /// the last counts. Throws Error{InvalidArgument} for a vertex that is not there, for a position
  /// that is not finite or farther than 10^6 diagonals off, and Error{Cancelled}: then nothing has
  /// moved.
  EditChange move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> positions,
                  const Callbacks& callbacks = {});
  /// Moves a selection by an affine map p -> m p, each vertex by its weight of the way. Throws as
  /// move().
  EditChange transform(const Selection& selection, const glm::dmat4& map,
                       const Callbacks& callbacks = {});
  /// The vertices around some others: see select_around().
  [[nodiscard]] Selection select(std::span<const std::int32_t> vertices, double radius) const;

  /// Tags edges and vertices of the mesh: of kInfiniteSharpness, sharp; of 0, smooth again. That is
  /// another system with other rows: it is solved from where it is, its rows are made, and all that
  /// the editor has given before ends, queries() too; sector angles are those of the mesh as it is
  /// now. The fair method makes its net anew. Takes the time of a whole solve and evaluation. Moves
  /// can still be taken back, tags are set back by this. Throws Error{InvalidArgument} for an edge
  /// or vertex that is not there, another sharpness, a fit that does not look at tags, and where
  /// the new system is not solved; Error{Cancelled}: then nothing has changed.
  EditChange set_sharp(std::span<const CreaseEdge> edges, std::span<const CornerVertex> corners,
                       const Callbacks& callbacks = {});
  /// The same as another editor, whose everything() is then the change; what this one has given
  /// stays, for hosts whose callers still look at it. Throws as set_sharp().
  [[nodiscard]] Editor with_sharp(std::span<const CreaseEdge> edges,
                                  std::span<const CornerVertex> corners,
                                  const Callbacks& callbacks = {}) const;
  /// All rows and control points, as the change that a new editor is to its caller.
  [[nodiscard]] EditChange everything();

  /// Takes back the last move that was not yet taken back, or does it again; nothing where there is
  /// none.
  EditChange undo(const Callbacks& callbacks = {});
  EditChange redo(const Callbacks& callbacks = {});
  [[nodiscard]] bool can_undo() const;
  [[nodiscard]] bool can_redo() const;

  /// Solves the whole mesh from where it is; of the fair method, builds the net anew with the fit's
  /// decisions: what a host does now and then. All rows may change. Throws Error{Cancelled}, and
  /// nothing has changed.
  EditChange settle(const Callbacks& callbacks = {});
  /// Makes what fit() makes of the mesh as it is now, with all that it decides: what a host does at
  /// the end of a drag or of all. The rows keep their numbers, moves can still be taken back, and
  /// rest_positions() are those of now; but all that the editor has given before ends, as with
  /// set_sharp(). Takes the time of a whole fit, of the fair method several times that of settle().
  /// Throws Error{InvalidArgument} where that misses the tolerance, Error{Cancelled}: then nothing
  /// has changed.
  EditChange refit(const Callbacks& callbacks = {});
  /// The same as another editor, as with_sharp() has it.
  [[nodiscard]] Editor refitted(const Callbacks& callbacks = {}) const;

  /// The mesh's vertices where they are now.
  [[nodiscard]] std::span<const glm::dvec3> points() const;
  /// Where they were in the fit, or when set_sharp() or refit() was called last: sector angles at
  /// corners stay those of this pose.
  [[nodiscard]] std::span<const glm::dvec3> rest_positions() const;
  /// How far the surface is from any of them at most, as a part of the diagonal.
  [[nodiscard]] double error_bound() const;
  /// The same, measured anew from all rows in double.
  [[nodiscard]] double measured_error() const;

  /// The rows of the level, in the mesh's coordinates: those of SurfaceMesh of the same level.
  /// Moves change them in place.
  [[nodiscard]] std::span<const glm::dvec3> positions() const;
  [[nodiscard]] std::span<const glm::vec3> normals() const;

  /// The mesh and the fit of it as they are now. Its errors are measured anew, and it has converged
  /// where they are within the tolerance. To evaluate it, give rest_positions().
  [[nodiscard]] PolygonMesh mesh() const;
  [[nodiscard]] Fit fit() const;
  /// Closest points and rays of the surface as it is now, places and curvature by their surface().
  /// The first call makes the tree, which takes time for all of the mesh; moves keep it right at
  /// the cost of what they reach, and settle() makes it anew. Not while another thread asks. Throws
  /// Error{UnusableMesh} where all faces are holes.
  [[nodiscard]] const SurfaceQueries& queries();
  /// The surface as it is now, for writers, of any level; the editor must outlive it, and moves
  /// change it. Its texture coordinates are those of a surface of mesh() and fit(): they go by
  /// where the control points are now. A host that deforms what it shows keeps those that it has:
  /// moves change no row of them in what the editor itself keeps.
  [[nodiscard]] std::unique_ptr<SurfaceBlocks> blocks(int level) const;

 private:
  class Impl;
  explicit Editor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// What was fitted, as an editor of it has it now.
[[nodiscard]] FittedMesh edited(const FittedMesh& first, const Editor& editor);

}  // namespace planish
