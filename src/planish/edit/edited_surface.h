#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/core/range.h"
#include "planish/core/raw_vector.h"
#include "planish/edit/sparse_set.h"
#include "planish/patches/patch_surface.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

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

}  // namespace planish
