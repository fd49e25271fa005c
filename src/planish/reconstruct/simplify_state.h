#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "planish/mesh/edge_groups.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish {

/// Weighted sum of squared distances to planes, as a function of position.
/// Source: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  glm::dvec3 linear{0.0};
  double constant = 0;
  double weight = 0;

  /// The plane through `point` with a unit normal.
  void add_plane(const glm::dvec3& normal, const glm::dvec3& point, double w) {
    const double offset = glm::dot(normal, point);
    xx += w * normal.x * normal.x;
    xy += w * normal.x * normal.y;
    xz += w * normal.x * normal.z;
    yy += w * normal.y * normal.y;
    yz += w * normal.y * normal.z;
    zz += w * normal.z * normal.z;
    linear -= w * offset * normal;
    constant += w * offset * offset;
    weight += w;
  }
  void add(const Quadric& other) {
    xx += other.xx;
    xy += other.xy;
    xz += other.xz;
    yy += other.yy;
    yz += other.yz;
    zz += other.zz;
    linear += other.linear;
    constant += other.constant;
    weight += other.weight;
  }
  [[nodiscard]] double at(const glm::dvec3& p) const {
    const glm::dvec3 product(xx * p.x + xy * p.y + xz * p.z, xy * p.x + yy * p.y + yz * p.z,
                             xz * p.x + yz * p.y + zz * p.z);
    // Rounding may take it below 0.
    return glm::max(glm::dot(p, product) + 2 * glm::dot(linear, p) + constant, 0.0);
  }
};

/// A unit vector in 4 bytes, to 0.01 degrees; or none.
/// Source: Z. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
/// 2014 (the octahedral map).
class PackedNormal {
 public:
  PackedNormal() = default;
  /// Of any length; none where that is 0.
  explicit PackedNormal(const glm::dvec3& v) {
    const double sum = std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
    if (!(sum > 0)) return;
    double x = v.x / sum, y = v.y / sum;
    if (v.z < 0) {
      const double folded = std::copysign(1 - std::abs(y), x);
      y = std::copysign(1 - std::abs(x), y);
      x = folded;
    }
    x_ = static_cast<std::int16_t>(std::lround(kScale * x));
    y_ = static_cast<std::int16_t>(std::lround(kScale * y));
  }
  /// Unit, or 0 for none.
  [[nodiscard]] glm::vec3 get() const {
    if (x_ == kNone) return glm::vec3(0.0f);
    double x = x_ / kScale, y = y_ / kScale;
    const double z = 1 - std::abs(x) - std::abs(y);
    if (z < 0) {
      const double folded = std::copysign(1 - std::abs(y), x);
      y = std::copysign(1 - std::abs(x), y);
      x = folded;
    }
    return glm::vec3(glm::dvec3(x, y, z) / std::sqrt(x * x + y * y + z * z));
  }

 private:
  static constexpr double kScale = 32767;
  static constexpr std::int16_t kNone = -32768;
  std::int16_t x_ = kNone, y_ = 0;
};

/// Triangles of a mesh that give way to fewer or as many new ones.
struct TriangleChange {
  std::int32_t removed_vertex = -1;     ///< whose point is a vertex no more; -1: none
  std::int32_t added_point = -1;        ///< that becomes a vertex; -1: none
  std::vector<std::int32_t> old_slots;  ///< indices of the triangles that go
  std::vector<Triangle> triangles;      ///< that come
  std::vector<std::int32_t> slots;      ///< indices that they take, all of them among old_slots

  void clear() {
    removed_vertex = added_point = -1;
    old_slots.clear();
    triangles.clear();
    slots.clear();
  }
};

/// The triangles around a vertex, counter-clockwise.
struct Fan {
  std::vector<std::int32_t> spokes;  ///< half-edges out of the vertex, one a triangle
  std::vector<std::int32_t> ring;    ///< neighbours; one more than spokes where it is open
  bool closed = true;
};

/// A triangle mesh whose edges can be collapsed and flipped. Stays an oriented manifold of the
/// same topology when can_collapse() and can_flip() are obeyed.
class CollapseMesh {
 public:
  /// The triangles must be an oriented manifold.
  CollapseMesh(std::span<const Triangle> triangles, std::size_t vertex_count);

  [[nodiscard]] std::size_t vertex_count() const { return outgoing_.size(); }
  [[nodiscard]] std::size_t triangle_count() const { return corners_.size() / 3; }
  [[nodiscard]] bool is_used(std::int32_t vertex) const { return outgoing_[vertex] >= 0; }
  [[nodiscard]] bool is_alive(std::int32_t triangle) const { return corners_[3 * triangle] >= 0; }
  [[nodiscard]] bool is_boundary(std::int32_t vertex) const {
    return twins_[outgoing_[vertex]] < 0;
  }
  [[nodiscard]] std::int32_t valence(std::int32_t vertex) const { return valences_[vertex]; }
  [[nodiscard]] std::int32_t start(std::int32_t half_edge) const { return corners_[half_edge]; }
  [[nodiscard]] std::int32_t end(std::int32_t half_edge) const {
    return corners_[next_half_edge(half_edge)];
  }
  [[nodiscard]] std::int32_t twin(std::int32_t half_edge) const { return twins_[half_edge]; }
  [[nodiscard]] Triangle triangle(std::int32_t index) const {
    return {corners_[3 * index], corners_[3 * index + 1], corners_[3 * index + 2]};
  }

  /// Fills `fan`; its vectors are used again.
  void get_fan(std::int32_t vertex, Fan& fan) const;
  /// Calls visit(neighbour) for every neighbour of a vertex.
  template <class Visit>
  void for_each_neighbour(std::int32_t vertex, const Visit& visit) const {
    const std::int32_t first = outgoing_[vertex];
    std::int32_t h = first;
    do {
      visit(end(h));
      const std::int32_t before = previous_half_edge(h);
      h = twins_[before];
      if (h < 0) visit(start(before));
    } while (h >= 0 && h != first);
  }

  /// Whether collapsing the vertex of `fan` into its ring's entry `target` keeps the topology (the
  /// link condition) and leaves no vertex next to them below valence 3, inside, or 2, on the
  /// boundary.
  [[nodiscard]] bool can_collapse(std::int32_t vertex, const Fan& fan, std::size_t target);
  /// Moves all triangles of the vertex to ring[target] and drops the one or two between them.
  void collapse(std::int32_t vertex, const Fan& fan, std::size_t target);

  /// Whether the edge is inside and its flipped self does not exist yet.
  [[nodiscard]] bool can_flip(std::int32_t half_edge);
  /// Turns the edge inside its two triangles, which keep their indices: the half-edge's triangle
  /// becomes (c, d, b) and its twin's (d, c, a) for an edge a b with opposite corners c and d.
  void flip(std::int32_t half_edge);

 private:
  void set_outgoing(std::int32_t vertex, std::int32_t half_edge);
  void glue(std::int32_t a, std::int32_t b);
  [[nodiscard]] bool are_neighbours(std::int32_t a, std::int32_t b) const;

  std::vector<std::int32_t> corners_;   // vertex that a half-edge starts at; -1: removed
  std::vector<std::int32_t> twins_;     // -1 on the boundary
  std::vector<std::int32_t> outgoing_;  // of a vertex, the first of an open fan; -1: unused
  std::vector<std::int32_t> valences_;  // edges at a vertex
  std::vector<std::uint32_t> marks_;    // for can_collapse
  std::uint32_t mark_ = 0;
};

/// An edge less at a vertex, named by its other end (-1: none), and an edge more, by the place of
/// its other end (null: none).
struct EdgeChange {
  std::int32_t without = -1;
  const glm::dvec3* with = nullptr;
};

/// Holds the ratio of the longest to the shortest edge at every vertex below a limit.
class EdgeGradation {
 public:
  /// Keeps references to both.
  EdgeGradation(std::span<const glm::dvec3> positions, const CollapseMesh& mesh,
                double largest_ratio)
      : positions_(positions), mesh_(mesh), largest_squared_ratio_(largest_ratio * largest_ratio) {}

  /// Whether a vertex stays within the ratio, or becomes no worse.
  [[nodiscard]] bool keeps(std::int32_t vertex, const EdgeChange& change) const;
  /// Whether collapsing the vertex of `fan` into its ring's entry `target` leaves all of the ring
  /// within the ratio, or within the worst that it and the vertex have.
  [[nodiscard]] bool keeps_all(std::int32_t vertex, const Fan& fan, std::size_t target) const;

  /// Whether moving the vertex of `fan` keeps both it and all of the ring.
  [[nodiscard]] bool keeps_moved(std::int32_t vertex, const glm::dvec3& place,
                                 const Fan& fan) const;

 private:
  [[nodiscard]] double squared_ratio(std::int32_t vertex, const EdgeChange& change) const;

  std::span<const glm::dvec3> positions_;
  const CollapseMesh& mesh_;
  double largest_squared_ratio_;
};

/// What the shape of a triangle must not fall below.
struct TriangleQuality {
  double largest_cosine = -1;  ///< of the smallest angle; smaller is better
  double facing = 1;           ///< least cosine between its normal and a corner's; larger is better
  double longest_squared = 0, shortest_squared = 0;  ///< edges

  void take_worst(const TriangleQuality& other);
};

/// A corner of a triangle with its normal, unit or 0 for none.
struct JudgedCorner {
  glm::dvec3 place;
  glm::vec3 normal;
};

/// Measures triangles against the surface that they came from.
class ShapeJudge {
 public:
  /// Keeps the angle-weighted vertex normals of the given mesh, and the span of positions, which
  /// may change: set_normal() says what belongs to the new place.
  ShapeJudge(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);

  [[nodiscard]] TriangleQuality quality(const JudgedCorner& a, const JudgedCorner& b,
                                        const JudgedCorner& c) const;
  [[nodiscard]] TriangleQuality quality(std::int32_t a, std::int32_t b, std::int32_t c) const {
    return quality(corner(a), corner(b), corner(c));
  }
  [[nodiscard]] JudgedCorner corner(std::int32_t vertex) const {
    return {positions_[vertex], normals_[vertex]};
  }
  /// Twice the area of a triangle times the mean over its corners of 1 - cosine of the angle
  /// between its normal and the corner's.
  [[nodiscard]] double deviation(std::int32_t a, std::int32_t b, std::int32_t c) const;
  /// Unit, or zero where the vertex has none.
  [[nodiscard]] glm::dvec3 normal(std::int32_t vertex) const {
    return glm::dvec3(normals_[vertex]);
  }
  void set_normal(std::int32_t vertex, const glm::vec3& normal) { normals_[vertex] = normal; }

 private:
  std::span<const glm::dvec3> positions_;
  std::vector<glm::vec3> normals_;  // zero where a vertex has none
};

/// Points that are no vertices any more, each carried by one triangle.
class PointCarrier {
 public:
  PointCarrier(std::size_t point_count, std::size_t triangle_count)
      : next_(point_count, -1), heads_(triangle_count, -1) {}

  void put(std::int32_t point, std::int32_t triangle) {
    next_[point] = heads_[triangle];
    heads_[triangle] = point;
  }
  /// Adds the points of a triangle to `points`; they stay where they are.
  void list(std::int32_t triangle, std::vector<std::int32_t>& points) const {
    for (std::int32_t p = heads_[triangle]; p >= 0; p = next_[p]) points.push_back(p);
  }
  void clear(std::int32_t triangle) { heads_[triangle] = -1; }

 private:
  std::vector<std::int32_t> next_, heads_;
};

/// Finds for each point the nearest shape. Stops and returns the place in `points` of the first
/// that is farther than the tolerance from every shape; -1 if there is none, `nearest` then holds
/// the index of each point's shape.
[[nodiscard]] std::int64_t find_nearest_shapes(const OrderedPoints& positions,
                                               std::span<const std::int32_t> points,
                                               std::span<const TriangleShape> shapes,
                                               double squared_tolerance,
                                               std::vector<std::int32_t>& nearest);

/// Points that are no vertices any more, each within a tolerance of the triangle that carries it.
class CarriedPoints {
 public:
  /// Keeps the points, and the spans of the vertices' positions and points; the tolerance is a
  /// length. `carriers` names each point's triangle, -1 for none.
  CarriedPoints(const OrderedPoints& points, std::span<const glm::dvec3> positions,
                std::span<const std::int32_t> vertex_points, std::span<const std::int32_t> carriers,
                std::size_t triangle_count, double tolerance);

  /// Adds the points that a triangle carries to `points`.
  void list(std::int32_t triangle, std::vector<std::int32_t>& points) const {
    carrier_.list(triangle, points);
  }

  /// Whether all points of the old triangles, and the removed vertex, stay within the tolerance of
  /// the new ones. The added point, one of those, is carried no more.
  [[nodiscard]] bool can_move(const TriangleChange& change);
  /// Moves them, for the change that can_move() has just allowed.
  void move(const TriangleChange& change);
  /// To be called for each vertex whose triangles have changed.
  void forget_failure(std::int32_t vertex) { failures_[vertex] = -1; }

 private:
  const OrderedPoints& points_;
  std::span<const glm::dvec3> positions_;  // of vertices
  std::span<const std::int32_t> vertex_points_;
  double squared_tolerance_;
  PointCarrier carrier_;
  std::vector<std::int32_t> failures_;  // by removed vertex: the point that stood in the way last
  std::vector<TriangleShape> shapes_;
  std::vector<std::int32_t> moved_, nearest_;
};

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

/// A vertex in a queue of collapses: the cheapest comes first, of equal ones the lowest. Entries
/// of an older version than the vertex has are stale.
struct CollapseEntry {
  double cost;
  std::int32_t vertex;
  std::uint32_t version;
  [[nodiscard]] bool operator<(const CollapseEntry& other) const {
    return cost > other.cost || (cost == other.cost && vertex > other.vertex);
  }
};

/// Half-edge collapses, the cheapest first, until none is allowed or the target is reached.
class CollapsePass {
 public:
  /// Keeps the state.
  explicit CollapsePass(SimplifyState& state)
      : state_(state), waiting_(state.positions.size(), Waiting{}) {}

  /// Looks at the vertices that are due.
  void run();

 private:
  // What a vertex waits for in the queue; entries of an older version are stale.
  struct Waiting {
    double cost = std::numeric_limits<double>::infinity();
    std::uint32_t version = 0;
  };
  using Entry = CollapseEntry;
  struct Candidate {
    double cost;
    std::size_t target;  // of the fan's ring
  };

  [[nodiscard]] double cost_of(std::int32_t vertex, std::int32_t target) const;
  [[nodiscard]] double least_cost(std::int32_t vertex) const;
  void fill_queue();
  void push(std::int32_t vertex, double cost);
  void list_candidates(std::int32_t vertex);
  void collapse_best(const Entry& entry);
  bool try_collapse(std::int32_t vertex, std::size_t target);
  bool keeps_valences(std::int32_t vertex, std::size_t target) const;
  bool keeps_shape(std::int32_t vertex, std::size_t target);
  void apply(std::int32_t vertex, std::size_t target);

  SimplifyState& state_;
  std::vector<Waiting> waiting_;  // by vertex
  std::priority_queue<Entry> queue_;
  // Used again from step to step.
  Fan fan_;
  std::vector<Candidate> candidates_;
  TriangleChange change_;
};

/// Flips the edges at vertices that are due where the triangles then follow the samples' normals
/// better or have less sharp angles, until nothing more is gained.
class FlipPass {
 public:
  /// Keeps the state.
  explicit FlipPass(SimplifyState& state) : state_(state) {}

  void run();

 private:
  // An edge a b with the opposite corners c and d of its two triangles.
  using Diamond = std::array<std::int32_t, 4>;

  bool try_flip(std::int32_t half_edge);
  [[nodiscard]] bool keeps_valences(const Diamond& diamond) const;
  [[nodiscard]] bool gains(const Diamond& diamond) const;

  SimplifyState& state_;
  Fan fan_;
  TriangleChange change_;
};

/// Puts other samples in the place of inner vertices that are due, where these lie nearer to the
/// middle of their neighbours: the interpolating surface wiggles and folds where they do not. Frees
/// vertices, too: the next collapses find more room.
class MovePass {
 public:
  /// Keeps the state.
  explicit MovePass(SimplifyState& state) : state_(state) {}

  /// Looks once at every vertex that is due.
  void run();

 private:
  bool try_move(std::int32_t vertex);
  bool try_place(std::int32_t vertex, std::int32_t sample);
  void list_samples(std::int32_t vertex);

  SimplifyState& state_;
  // Used again from vertex to vertex.
  Fan fan_;
  TriangleChange change_;
  std::vector<std::int32_t> inside_;                      // points of the fan
  std::vector<std::pair<double, std::int32_t>> samples_;  // with their distance to the middle
};

}  // namespace planish
