#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <ranges>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/point_tree.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish {

/// The entries of an array that `indices` name, in that order.
template <std::ranges::random_access_range Array>
[[nodiscard]] auto chosen(const Array& array, std::span<const std::int32_t> indices) {
  std::vector<std::ranges::range_value_t<Array>> result;
  result.reserve(indices.size());
  for (const std::int32_t index : indices) result.push_back(array[index]);
  return result;
}

/// Moves every point onto its local quadratic fit (clean.cpp), `rounds` times. Points without a
/// stable fit stay, and with `noise`, a length above 0, those beside an edge: about whose fit the
/// neighbours deviate by much more. Throws Error{Cancelled}.
[[nodiscard]] std::vector<glm::dvec3> smooth_points(std::span<const glm::dvec3> points,
                                                    std::int32_t rounds, double noise = 0,
                                                    const Callbacks& callbacks = {});
void smooth_points(OrderedPoints& points, std::int32_t rounds, double noise,
                   const Callbacks& callbacks);

/// Standard deviation of the points along the normals of the surface that they are samples of,
/// from `sample_count` of them at most, evenly picked. What a quadratic cannot follow at edges
/// grows with the number of points that are fitted, in variance as that number or faster; noise
/// does not. So the variance about fits to 24 points, taken off twice that about fits to 12, leaves
/// noise alone; 0 where nothing is left.
[[nodiscard]] double measure_noise(std::span<const glm::dvec3> points,
                                   std::int32_t sample_count = 5000);
[[nodiscard]] double measure_noise(const OrderedPoints& points, const OrderedTree& tree,
                                   std::int32_t sample_count = 5000);

/// The rules of clean() for a cloud whose points need not all be looked at closely: what is usual
/// comes from a sample of them, and strays are looked for where it is asked for.
class PointCritic {
 public:
  /// Keeps references to the points, without duplicates, and to the options. Removes the points
  /// that are far from all others. Warns "uneven-density". Throws Error{Cancelled}.
  PointCritic(OrderedPoints& points, const CleanOptions& options);

  /// Median of the mean distances to the 6 nearest.
  [[nodiscard]] double spacing() const { return spacing_; }
  /// As measure_noise().
  [[nodiscard]] double noise() const;

  /// Of the planes that the points around those asked for scatter about: unit, either way, or 0.
  [[nodiscard]] std::vector<glm::dvec3> normals_at(std::span<const std::int32_t> asked) const;

  /// Removes those of `asked` that stray from the surface around them, and then those that these
  /// hid. That changes the indices of the points: `asked` and `followed`, both ascending, name the
  /// same points afterwards, less those removed. Throws Error{Cancelled}.
  void remove_strays(std::vector<std::int32_t>& asked, std::vector<std::int32_t>& followed);
  void remove_all_strays();

  [[nodiscard]] std::int64_t outlier_count() const { return outlier_count_; }
  [[nodiscard]] std::int64_t stray_count() const { return stray_count_; }

 private:
  void measure_sample();
  void remove_outliers(double farthest);
  [[nodiscard]] bool is_outlier(std::int32_t point, double farthest) const;
  [[nodiscard]] std::vector<std::int32_t> around(std::span<const glm::dvec3> places,
                                                 std::span<const std::int32_t> starts) const;

  OrderedPoints& points_;
  const CleanOptions& options_;
  std::optional<OrderedTree> tree_;
  double spacing_ = 0;
  bool judges_strays_ = false;
  std::int64_t outlier_count_ = 0, stray_count_ = 0;
};

/// Of a mesh's largest component, in triangles: smaller ones are scraps beside it.
[[nodiscard]] constexpr std::int64_t least_part(std::int64_t largest) { return largest / 50; }

/// Triangles that reach far beyond the spacing of the points around and do not close the gap that
/// they are in: flaps over a bay of an open sheet's rim, strips across a hole or between two
/// sheets. 1 for each of them, 0 for others. A patch of them counts as open where 0.2 of its rim is
/// boundary; one that closes a gap, such as a flat face of a part of which only the edges were
/// sampled, is none, and neither is one that holds what would be a scrap without it. Every vertex
/// keeps a triangle. No edge may have more than two.
[[nodiscard]] std::vector<std::uint8_t> open_bridges(std::span<const glm::dvec3> positions,
                                                     std::span<const Triangle> triangles);

/// A hole to be closed.
struct Hole {
  std::vector<std::int32_t> loop;   ///< vertices so that a patch runs from each to the next
  std::vector<glm::dvec3> normals;  ///< unit normal of the triangle beyond edge i to i + 1
};

/// The triangulation of the loop whose largest dihedral angle, patch and rim taken together, is
/// least, and among these the one of least area. `is_edge(a, b)` tells edges that the mesh has
/// already, which the patch must not use inside. Empty if there is none.
/// Source: P. Liepa, "Filling Holes in Meshes", 2003, section 3. Time grows as the cube of the
/// loop's length.
[[nodiscard]] std::vector<Triangle> fill_hole(
    std::span<const glm::dvec3> positions, const Hole& hole,
    const std::function<bool(std::int32_t, std::int32_t)>& is_edge);

/// Turns every open component of an oriented manifold over where more of its triangles face away
/// from the normals of their corners, one per position, than along them. Closed ones stay: their
/// volume says where outside is. Returns how many were turned.
std::int64_t turn_by_normals(std::span<const glm::dvec3> positions,
                             std::span<const glm::vec3> normals, std::span<Triangle> triangles);

/// Chooses points one by one, in the order of `asked` (indices of `points`; else of all of them),
/// that are no nearer than `radius` to one chosen before nor to one of `samples`: a sampling
/// without gaps, none of whose points crowd. Time grows with their number and memory with the
/// number of those chosen.
/// Source: R. L. Cook, "Stochastic Sampling in Computer Graphics", 1986 (Poisson disks by dart
/// throwing).
[[nodiscard]] std::vector<std::int32_t> thin_points(
    const OrderedPoints& points, std::optional<std::span<const std::int32_t>> asked, double radius,
    std::span<const std::int32_t> samples);

// Every point looks for its nearest triangle from that of the point before it. All results are the
// same for every thread count; all functions throw Error{Cancelled}.

/// Fills mesh.carriers. Returns the points, none of them at a vertex, that are farther than
/// `limit`, ascending. Both are lengths; the tolerance is not below the limit.
[[nodiscard]] std::vector<std::int32_t> find_carriers(const OrderedPoints& points,
                                                      WitnessedMesh& mesh, double tolerance,
                                                      double limit, LoopProgress& progress);

/// Those of `asked` that are farther than `limit`, a length, from the mesh; in the same order.
[[nodiscard]] std::vector<std::int32_t> points_beyond(const OrderedPoints& points,
                                                      std::span<const std::int32_t> asked,
                                                      const WitnessedMesh& mesh, double limit);

/// Of all points to triangles whose corners are indices of `points`; so is `farthest`.
[[nodiscard]] PointDistances measure_distances(const OrderedPoints& points,
                                               std::span<const Triangle> triangles);

struct CoarseOptions {
  double tolerance = 0;                ///< a length, above 0
  std::int64_t least_samples = 0;      ///< about so many are meshed at first, or more
  TriangleRepairOptions repair;        ///< its callbacks are not used
  std::span<const glm::vec3> normals;  ///< of the points as they were given, or empty
  Callbacks callbacks;
};

/// A mesh through few of the points that all others are near.
struct CoarseMesh {
  WitnessedMesh mesh;
  std::int64_t sample_count = 0;    ///< points meshed at first
  std::int64_t inserted_count = 0;  ///< further ones, where points were beyond the tolerance
  std::int64_t meshing_count = 0;   ///< how often samples were meshed
  std::int64_t strayed_count = 0;   ///< points beyond the tolerance all the same
  std::int64_t filled_loop_count = 0, dropped_component_count = 0, turned_component_count = 0;
};

/// Thins the points, meshes and repairs what is left, asks all points how far they are from that,
/// and meshes anew with more samples where they are beyond the tolerance. Those chosen for samples
/// are looked at first, and the outliers among them removed from `points`; so are those that
/// object. Throws Error{UnusableMesh} where there is no surface, Error{Cancelled}, and what
/// `mesher` throws.
[[nodiscard]] CoarseMesh mesh_coarse_first(OrderedPoints& points, PointCritic& critic,
                                           const Mesher& mesher, const CoarseOptions& options);

}  // namespace planish
