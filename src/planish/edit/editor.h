#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "planish/core/callbacks.h"
#include "planish/core/range.h"
#include "planish/edit/selection.h"
#include "planish/limit/surface_queries.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

struct EditorOptions {
  int level = 2;        ///< of the rows that are kept, 0 to kMaxLevel
  FitOptions fit;       ///< those of the fit: scheme, weights, tolerance, sharp, polish_steps
  int undo_steps = 64;  ///< moves that can be taken back, 0: none; older ones are forgotten
};

/// What a move has changed. Spans hold until the editor's next call.
struct EditChange {
  std::span<const std::int32_t> vertices;  ///< of the mesh, that moved
  /// Vertices of the mesh whose control points moved along, in any order; of the fair method those
  /// around which control points of level 1 did.
  std::span<const std::int32_t> control_points;
  std::span<const RowRange> rows;  ///< ascending; no other row has other bits than before
  std::int64_t row_count = 0;      ///< in all ranges
  bool is_whole = false;           ///< the mesh was solved and evaluated whole
};

/// A fitted mesh whose vertices move: only what they reach is solved and evaluated again, so that a
/// move costs what it moves, not the size of the mesh. The surface passes through all vertices
/// within the fit's tolerance after any number of moves. Control points of a progressive fit are
/// within a small factor of it of those of a fit from scratch; those of a fair one differ by what
/// its polish does far off, until settle() (edit/README.md). What is sharp, corner sectors and the
/// fair method's decisions are those of the fit.
///
/// One thread at a time changes it. Constant functions, and what they return, may be used from many
/// threads while none does.
class Editor {
 public:
  /// `fit` is of `mesh`, which must outlive the editor; its positions are copied. Throws
  /// Error{InvalidArgument} for a fit that has not reached its tolerance, was allowed to leave the
  /// vertices (`within`) or is of another scheme than Doo-Sabin, Error{OutOfMemory}.
  Editor(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options = {});
  /// The same of all that fit_mesh() made.
  explicit Editor(const FittedMesh& fitted, int level = 2);
  Editor(PolygonMesh&& mesh, const Fit& fit, const EditorOptions& options = {}) = delete;
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

  /// Takes back the last move that was not yet taken back, or does it again; nothing where there is
  /// none.
  EditChange undo(const Callbacks& callbacks = {});
  EditChange redo(const Callbacks& callbacks = {});
  [[nodiscard]] bool can_undo() const;
  [[nodiscard]] bool can_redo() const;

  /// Solves the whole mesh from where it is; of the fair method, builds the net anew with the fit's
  /// decisions. All rows may change. Throws Error{Cancelled}, and nothing has changed.
  EditChange settle(const Callbacks& callbacks = {});

  /// The mesh's vertices where they are now.
  [[nodiscard]] std::span<const glm::dvec3> points() const;
  /// How far the surface is from any of them at most, as a part of the diagonal.
  [[nodiscard]] double error_bound() const;
  /// The same, measured anew from all rows in double.
  [[nodiscard]] double measured_error() const;

  /// The rows of the level, in the mesh's coordinates: those of SurfaceMesh of the same level.
  /// Moves change them in place.
  [[nodiscard]] std::span<const glm::dvec3> positions() const;
  [[nodiscard]] std::span<const glm::vec3> normals() const;

  /// The mesh and the fit of it as they are now.
  [[nodiscard]] PolygonMesh mesh() const;
  [[nodiscard]] Fit fit() const;
  /// The surface as it is now, for writers, of any level; the editor must outlive it, and moves
  /// change it.
  [[nodiscard]] std::unique_ptr<SurfaceBlocks> blocks(int level) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planish
