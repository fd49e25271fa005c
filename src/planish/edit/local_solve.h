#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/core/raw_vector.h"
#include "planish/edit/measured_error.h"
#include "planish/edit/sparse_set.h"
#include "planish/interpolate/progressive.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/limit_system.h"

namespace planish {

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

}  // namespace planish
