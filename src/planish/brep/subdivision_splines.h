#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "planish/brep/spline_surface.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/primal/primal_stencils.h"
#include "planish/queries/limit_surface.h"
#include "planish/surface/evaluate.h"

namespace planish {

/// A Doo-Sabin surface, of degree 2. The limit surface must outlive it.
class DooSabinSplines : public SplineSurface {
 public:
  explicit DooSabinSplines(const LimitSurface& surface) : surface_(surface) {}

  [[nodiscard]] std::size_t degree() const override { return 2; }
  [[nodiscard]] const MeshTopology& topology() const override { return surface_.topology(); }
  [[nodiscard]] const Placement& placement() const override {
    return surface_.surface().placement();
  }
  [[nodiscard]] std::span<const std::uint8_t> hidden() const override {
    return surface_.surface().hidden();
  }
  [[nodiscard]] bool is_sharp(std::int32_t corner) const override {
    return surface_.surface().patches().is_sharp(corner);
  }
  [[nodiscard]] bool is_singular_at_vertex(std::int32_t corner) const override {
    return surface_.form(corner).is_singular_at_vertex();
  }
  [[nodiscard]] std::unique_ptr<SplinePatch> patch() const override;

 private:
  const LimitSurface& surface_;
};

/// The Catmull-Clark surface of a cage, of degree 3, with OpenSubdiv's rules. Its quads are those
/// of M_1, face c of which is that of the mesh's corner c.
class CatmullClarkSplines : public SplineSurface {
 public:
  /// The cage must outlive it. Takes what is sharp and what was prepared of the options. Throws
  /// Error{UnusableMesh}, also for creases and corners that are semi-sharp still on M_1;
  /// Error{OutOfMemory} before memory is taken.
  CatmullClarkSplines(const PolygonMesh& cage, const EvaluateOptions& options);

  [[nodiscard]] std::size_t degree() const override { return 3; }
  [[nodiscard]] const MeshTopology& topology() const override { return *used_.prepared->topology; }
  [[nodiscard]] const Placement& placement() const override { return placement_; }
  [[nodiscard]] std::span<const std::uint8_t> hidden() const override { return hidden_; }
  [[nodiscard]] bool is_sharp(std::int32_t corner) const override;
  [[nodiscard]] bool is_singular_at_vertex(std::int32_t corner) const override {
    return singular_[corner] != 0;
  }
  [[nodiscard]] std::unique_ptr<SplinePatch> patch() const override;

  // For patches.

  [[nodiscard]] bool is_singular_at_face(std::int32_t corner) const {
    return topology().face_size(topology().face_of(corner)) != 4;
  }
  /// Bezier points of a corner's patch around which all vertices of M_1 are regular.
  [[nodiscard]] PointNet whole_net(std::int32_t corner) const;
  /// The same of its quarter at V, E1, F or E2 (0 to 3), regular on M_2.
  [[nodiscard]] PointNet quarter_net(std::int32_t corner, int quarter) const;
  /// Points of M_2 on a corner's patch, (a, b) at a + 3 b, a along u.
  [[nodiscard]] std::array<glm::dvec3, 9> points_on(std::int32_t corner) const;
  [[nodiscard]] float vertex_sharpness(std::int32_t vertex) const;

 private:
  void require_settled() const;
  void find_singular();
  [[nodiscard]] RawVector<glm::dvec3> refined(int level, std::span<const glm::dvec3> points) const;
  [[nodiscard]] int place_of_vertex(std::int32_t corner) const;
  [[nodiscard]] PointNet net_of(int level, int face, int first) const;
  [[nodiscard]] glm::dvec3 inner_point(int level, int face, int place) const;
  [[nodiscard]] glm::dvec3 edge_point(int level, int face, int place, int towards) const;
  [[nodiscard]] glm::dvec3 corner_point(int level, int vertex) const;

  UsedPart used_;
  PrimalSplit split_;
  Placement placement_;
  std::vector<std::uint8_t> hidden_, singular_;
  std::array<RawVector<glm::dvec3>, 3> points_;  // by level, in unit coordinates; of 0 none
};

}  // namespace planish
