#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/reconstruct/carried_points.h"
#include "planish/reconstruct/collapse_mesh.h"
#include "planish/reconstruct/edge_gradation.h"
#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/packed_normal.h"
#include "planish/reconstruct/quadric.h"
#include "planish/reconstruct/shape_limits.h"
#include "planish/reconstruct/simplify.h"
#include "planish/reconstruct/witnessed_mesh.h"

namespace planish {

/// The passes that a vertex waits for since its triangles changed; bits.
enum class Pass : std::uint8_t { Collapse = 1, Flip = 2, Move = 4 };

/// A mesh on the way through the passes of simplify(). What is large is kept for vertices alone; a
/// carried point takes 8 bytes.
class SimplifyState {
 public:
  /// Keeps references to the points and the options.
  SimplifyState(const OrderedPoints& points, WitnessedMesh witnessed,
                const SimplifyOptions& options);

  /// Notes that the triangles of a vertex have changed.
  void touch(std::int32_t vertex) {
    due[vertex] = 7;
    carried.forget_failure(vertex);
  }
  [[nodiscard]] bool waits(std::int32_t vertex, Pass pass) const {
    return (due[vertex] & static_cast<std::uint8_t>(pass)) != 0;
  }
  /// Whether a vertex of the mesh waits for a pass, which it then does no more.
  [[nodiscard]] bool take(std::int32_t vertex, Pass pass);

  /// Worst of the triangles around a vertex.
  [[nodiscard]] TriangleQuality worst_of(const Fan& fan) const;
  /// Whether triangles are within the limits, or at least no worse than those they replace.
  template <class Before>
  [[nodiscard]] bool allows(const TriangleQuality& after, const Before& before) const {
    if (after.largest_cosine <= largest_cosine && after.facing >= kLeastFacing) return true;
    const TriangleQuality was = before();
    return after.largest_cosine <= std::max(largest_cosine, was.largest_cosine) &&
           after.facing >= std::min(kLeastFacing, was.facing);
  }

  /// Of the given mesh at a point: a vertex' own, or between those of the triangle's corners; 0
  /// where there is none.
  [[nodiscard]] glm::vec3 normal_of_point(std::int32_t point) const {
    return point_normals[point].get();
  }

  /// Shares of the time when a round begins and ends, for progress.
  void begin_round(double begin, double end);
  /// To be called for each small piece of work: reports progress. Throws Error{Cancelled}.
  void count_step();
  [[nodiscard]] bool is_done() const {
    return options.target_vertices > 0 && result.vertex_count <= options.target_vertices;
  }

  const OrderedPoints& points;
  const SimplifyOptions& options;
  std::vector<std::int32_t> vertex_points;  // by vertex
  std::vector<glm::dvec3> positions;        // by vertex: that point's place
  CollapseMesh mesh;
  ShapeJudge judge;
  EdgeGradation gradation;
  std::vector<PackedNormal> point_normals;  // by point
  CarriedPoints carried;
  std::vector<Quadric> quadrics;  // by vertex
  std::vector<std::uint8_t> due;  // by vertex, bits of Pass
  double largest_cosine = 1;
  std::int32_t max_valence = 0;
  SimplifiedMesh result;

  /// Inside, a vertex keeps so many edges.
  static constexpr std::int32_t kLeastInnerValence = 4;

 private:
  // A new triangle may lean this far from the samples' normals: 60 degrees. Two that share a corner
  // then never face each other.
  static constexpr double kLeastFacing = 0.5;

  void add_plane(const Triangle& triangle);
  [[nodiscard]] std::vector<PackedNormal> normals_of_points(const WitnessedMesh& witnessed) const;

  double round_begin_ = 0, round_end_ = 1;
  std::int64_t round_count_ = 0;  // of vertices when it began
  std::int64_t steps_ = 0;
};

}  // namespace planish
