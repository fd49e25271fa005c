#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/quality_sum.h"

namespace planish {

/// Where a surface has no normal: at corners that no boundary, and no edge with a tag, ends at, as
/// a cone's apex. Figures take the one that is beside it in each face.
class ApexNormals {
 public:
  /// Of a surface of `mesh`, which passes check() and must outlive it.
  explicit ApexNormals(const PolygonMesh& mesh);

  /// The place of such a vertex of a face of the mesh, or null; of several the last.
  [[nodiscard]] const glm::dvec3* apex_of(std::int32_t face) const;

 private:
  const PolygonMesh& mesh_;
  std::vector<std::uint8_t> is_apex_;  // by vertex; empty where there is none
};

/// Puts, in the corner of a surface's face that lies at `apex`, if one does, the direction of the
/// sum of both normals beside it in place of its own.
void leave_out_apex(const glm::dvec3& apex, std::span<const glm::dvec3> positions,
                    std::span<glm::vec3> normals);

/// Gathers SurfaceQuality::folded_places from faces in ascending order.
class FoldedPlaces {
 public:
  /// `is_elsewhere`: counts in folded_area_elsewhere.
  void add(const FoldedPlace& place, bool is_elsewhere) {
    add_to(all_, place);
    if (is_elsewhere) add_to(elsewhere_, place);
  }

  /// Of later faces.
  void add(const FoldedPlaces& later) {
    for (const FoldedPlace& place : later.all_) add_to(all_, place);
    for (const FoldedPlace& place : later.elsewhere_) add_to(elsewhere_, place);
  }

  [[nodiscard]] const std::vector<FoldedPlace>& all() const { return all_; }
  [[nodiscard]] const std::vector<FoldedPlace>& elsewhere() const { return elsewhere_; }
  [[nodiscard]] std::vector<FoldedPlace> take() {
    return std::move(elsewhere_.empty() ? all_ : elsewhere_);
  }

 private:
  static void add_to(std::vector<FoldedPlace>& places, const FoldedPlace& place) {
    if (places.size() == kNamedFolds) return;
    if (places.empty() || places.back().face != place.face) places.push_back(place);
  }

  std::vector<FoldedPlace> all_, elsewhere_;
};

}  // namespace planish
