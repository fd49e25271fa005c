#include "planish/adaptive/decimate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <queue>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/adaptive/adaptive_blocks.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/queries/surface_queries.h"
#include "planish/reconstruct/simplify_state.h"
#include "planish/reconstruct/spatial_search.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/memory_need.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// So many samples for each vertex that is left: with more, distances change by a few per cent.
constexpr double kFiner = 4;
// The first tessellation, and the last, which only shapes with hardly a bend come to.
constexpr double kFirstChordError = 1e-3, kLeastChordError = 1e-6;
// What of a distance that is to be kept the samples take.
constexpr double kSampleShare = 0.25;
// Of a sample while it is collapsed, at most.
constexpr std::uint64_t kTriangleBytes = 260;
// That distances are measured from, each way.
constexpr std::size_t kMostPlaces = std::size_t{1} << 18;

void require_target(const DecimateOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, "decimate: " + what);
  };
  const DecimationTarget& target = options.target;
  if (!target.any()) refuse("neither triangles, an edge length nor a distance is given");
  if (target.triangles < 0) refuse(formatted("{} triangles are none", target.triangles));
  for (const double length : {target.edge_length, target.distance})
    if (!(length >= 0) || !std::isfinite(length))
      refuse("a length of " + shortest(length) + " is none");
  if (!(options.diagonal > 0) || !std::isfinite(options.diagonal))
    refuse("a diagonal of " + shortest(options.diagonal) + " is none");
}

std::vector<Triangle> triangles_of(const SurfaceMesh& surface) {
  std::vector<Triangle> triangles(static_cast<std::size_t>(surface.face_count()));
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) triangles[t][k] = surface.face_vertices[3 * t + k];
  return triangles;
}

// 0 for what is left of it by rounding.
double without_rounding(double distance) { return distance < 1e-12 ? 0 : distance; }

double area_of(const SurfaceMesh& surface) {
  double area = 0;
  for (const auto& [a, b, c] : triangles_of(surface)) {
    const auto& at = surface.positions;
    area += glm::length(glm::cross(at[b] - at[a], at[c] - at[a])) / 2;
  }
  return area;
}

// The corners of a tessellation with all that belongs to one: a row, a texture coordinate and a
// group. Where a row has several of the others, a seam runs through it.
class Wedges {
 public:
  explicit Wedges(const AdaptiveSurface& samples) {
    const SurfaceMesh& mesh = samples.mesh;
    std::vector<std::int32_t> first(mesh.positions.size(), -1), next;
    corners_.reserve(mesh.face_vertices.size());
    for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
      const std::int32_t row = mesh.face_vertices[c];
      const Wedge wedge{row, mesh.face_uvs.empty() ? -1 : mesh.face_uvs[c],
                        mesh.face_groups.empty() ? -1 : mesh.face_groups[c / 3],
                        samples.ancestors[c / 3]};
      std::int32_t at = first[row];
      while (at >= 0 && !all_[at].is_at(wedge)) at = next[at];
      if (at < 0) {
        at = static_cast<std::int32_t>(all_.size());
        all_.push_back(wedge);
        next.push_back(std::exchange(first[row], at));
      }
      corners_.push_back(at);
    }
  }

  struct Wedge {
    std::int32_t row, uv, group;
    std::int32_t ancestor;  // of a triangle that has it

    [[nodiscard]] bool is_at(const Wedge& other) const {
      return row == other.row && uv == other.uv && group == other.group;
    }
  };
  [[nodiscard]] const std::vector<Wedge>& all() const { return all_; }
  [[nodiscard]] std::span<const std::int32_t> corners() const { return corners_; }

 private:
  std::vector<Wedge> all_;
  std::vector<std::int32_t> corners_;
};

// Of triangles and of their edges, at most about so many.
std::vector<glm::dvec3> middles_of(const SurfaceMesh& surface) {
  const std::vector<Triangle> triangles = triangles_of(surface);
  const std::size_t step = 1 + 4 * triangles.size() / kMostPlaces;
  std::vector<glm::dvec3> middles;
  for (std::size_t t = 0; t < triangles.size(); t += step) {
    const auto corner = [&](std::size_t k) { return surface.positions[triangles[t][k % 3]]; };
    middles.push_back((corner(0) + corner(1) + corner(2)) / 3.0);
    for (std::size_t k = 0; k < 3; ++k) middles.push_back((corner(k) + corner(k + 1)) / 2.0);
  }
  return middles;
}

// Places of the surface: of the finest level up to the third that has not too many.
RawVector<glm::dvec3> places_on(const LimitSurface& surface) {
  constexpr int kFinest = 3;
  auto blocks = surface.surface().level(1);
  for (int level = 2; level <= kFinest; ++level) {
    auto finer = surface.surface().level(level);
    if (finer->info().row_count > static_cast<std::int64_t>(kMostPlaces)) break;
    blocks = std::move(finer);
  }
  RawVector<glm::dvec3> places(static_cast<std::size_t>(blocks->info().row_count));
  RawVector<glm::vec3> normals(places.size());
  RowTarget target;
  target.positions = places;
  target.normals = normals;
  (void)make_all_rows(*blocks, target, {});
  return places;
}

DecimationFigures figures_of(const AdaptiveSurface& made, const AdaptiveSurface& samples,
                             const LimitSurface& surface, double diagonal) {
  const SurfaceMesh& mesh = made.mesh;
  const RawVector<glm::dvec3> places = places_on(surface);
  const std::vector<glm::dvec3> middles = middles_of(mesh);
  const PointDistances to = measure_distances(places, mesh.positions, triangles_of(mesh));
  std::vector<double> back(middles.size());
  SurfaceQueries(surface).distances(middles, back);
  double largest = to.max, sum = static_cast<double>(places.size()) * to.rms * to.rms, lengths = 0;
  for (const double distance : back) {
    largest = std::max(largest, distance);
    sum += distance * distance;
  }
  for (const Triangle& triangle : triangles_of(mesh))
    for (std::size_t k = 0; k < 3; ++k)
      lengths += glm::length(mesh.positions[triangle[(k + 1) % 3]] - mesh.positions[triangle[k]]);
  const std::int64_t count = std::ssize(places) + std::ssize(middles);
  return {.max = without_rounding(largest / diagonal),
          .rms = without_rounding(std::sqrt(sum / static_cast<double>(count)) / diagonal),
          .places = count,
          .finer = samples.mesh.face_count(),
          .mean_edge_length = lengths / static_cast<double>(3 * mesh.face_count())};
}

// Vertices of the surface, by corner of the samples: rows that sharp edges copy are one. An edge
// has another on its other side by rows, or else by places, where these leave no choice: sheets
// that only touch stay apart.
std::vector<Triangle> joined_triangles(const SurfaceMesh& mesh) {
  struct HalfEdge {
    std::int32_t from, to, corner;
    [[nodiscard]] auto ends() const { return std::pair(from, to); }
  };
  const auto corner_count = static_cast<std::int32_t>(mesh.face_vertices.size());
  DisjointSets vertices(static_cast<std::size_t>(corner_count));
  // Joins ends of pairs; returns those without a partner.
  const auto join = [&](std::vector<HalfEdge> edges) {
    std::ranges::sort(edges, {}, [](const HalfEdge& e) { return std::pair(e.ends(), e.corner); });
    const auto alike = [&](const std::pair<std::int32_t, std::int32_t>& ends) {
      return std::ranges::equal_range(edges, ends, {}, &HalfEdge::ends);
    };
    std::vector<HalfEdge> left;
    for (const HalfEdge& edge : edges) {
      const auto across = alike({edge.to, edge.from});
      if (across.size() != 1 || alike(edge.ends()).size() != 1) {
        left.push_back(edge);
        continue;
      }
      vertices.unite(edge.corner, next_half_edge(across.front().corner));
      vertices.unite(next_half_edge(edge.corner), across.front().corner);
    }
    return left;
  };
  std::vector<HalfEdge> edges;
  for (std::int32_t c = 0; c < corner_count; ++c)
    edges.push_back({mesh.face_vertices[c], mesh.face_vertices[next_half_edge(c)], c});
  edges = join(std::move(edges));
  std::vector<std::int32_t> rows;
  for (const HalfEdge& edge : edges) rows.insert(rows.end(), {edge.from, edge.to});
  const auto place_of = [&](std::int32_t row) {
    const glm::dvec3& at = mesh.positions[row];
    return std::tuple(at.x, at.y, at.z);
  };
  std::ranges::sort(rows, {}, place_of);
  const auto number_of = [&](std::int32_t row) {
    return static_cast<std::int32_t>(std::ranges::lower_bound(rows, place_of(row), {}, place_of) -
                                     rows.begin());
  };
  for (HalfEdge& edge : edges) edge = {number_of(edge.from), number_of(edge.to), edge.corner};
  (void)join(std::move(edges));
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(corner_count), -1);
  std::vector<Triangle> triangles(static_cast<std::size_t>(corner_count) / 3);
  std::int32_t count = 0;
  for (std::int32_t c = 0; c < corner_count; ++c) {
    std::int32_t& number = numbers[vertices.find(c)];
    if (number < 0) number = count++;
    triangles[c / 3][c % 3] = number;
  }
  return triangles;
}

// Based on: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997
// (the order of collapses); H. Hoppe, "New Quadric Metric for Simplifying Meshes with Appearance
// Attributes", 1999 (wedges).

// Collapses half-edges of the samples, the cheapest first. Lines, which are edges whose sides have
// other wedges and borders, keep their ends and where they meet; their vertices run along them,
// with the wedges of both sides.
class Collapses {
 public:
  // `limit`: no collapse is farther from the planes of what it takes away, in the mean.
  Collapses(const SurfaceMesh& mesh, const Wedges& wedges, double limit)
      : wedges_(wedges), rows_(mesh), limit_(limit), count_(mesh.face_count()) {
    const std::vector<Triangle> triangles = joined_triangles(mesh);
    std::int32_t count = 0;
    for (const Triangle& t : triangles) count = std::max({count, t[0] + 1, t[1] + 1, t[2] + 1});
    positions_.resize(static_cast<std::size_t>(count));
    is_locked_.assign(positions_.size(), 0);
    is_given_.assign(positions_.size(), 0);
    std::vector<std::int32_t> vertex_of_row(mesh.positions.size(), -1);
    for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
      const std::int32_t vertex = triangles[c / 3][c % 3];
      positions_[vertex] = mesh.positions[mesh.face_vertices[c]];
      is_given_[vertex] = mesh.face_vertices[c] < std::ssize(mesh.base_vertices);
      std::int32_t& first = vertex_of_row[mesh.face_vertices[c]];
      if (first < 0) first = vertex;
      if (first != vertex) is_locked_[first] = is_locked_[vertex] = 1;  // sheets meet there
    }
    mesh_ = std::make_unique<CollapseMesh>(triangles, positions_.size());
    wedge_of_.assign(wedges.corners().begin(), wedges.corners().end());
    find_lines();
    add_planes();
    waiting_.resize(positions_.size());
    for (std::int32_t v = 0; v < count; ++v) push(v);
  }

  void run(std::int64_t triangles) {
    constexpr int kStopSteps = 1 << 12;
    for (int step = 0; count_ > triangles && !queue_.empty(); ++step) {
      if (step % kStopSteps == 0) check_stop();
      const Entry entry = queue_.top();
      queue_.pop();
      if (entry.version == waiting_[entry.vertex] && mesh_->is_used(entry.vertex))
        collapse_best(entry);
    }
  }

  // Wedges of the triangles that are left, three each.
  [[nodiscard]] std::vector<std::int32_t> corners() const {
    std::vector<std::int32_t> left;
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(mesh_->triangle_count()); ++t)
      if (mesh_->is_alive(t))
        left.insert(left.end(), wedge_of_.begin() + 3 * t, wedge_of_.begin() + 3 * t + 3);
    return left;
  }

 private:
  using Entry = CollapseEntry;
  struct Candidate {
    double cost;
    std::size_t target;  // of the fan's ring
    [[nodiscard]] auto order() const { return std::pair(cost, target); }
  };
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  void find_lines() {
    is_line_.assign(wedge_of_.size(), 0);
    for (std::int32_t h = 0; h < std::ssize(wedge_of_); ++h) {
      const std::int32_t twin = mesh_->twin(h);
      is_line_[h] = twin < 0 || wedge_of_[h] != wedge_of_[next_half_edge(twin)] ||
                    wedge_of_[next_half_edge(h)] != wedge_of_[twin];
    }
  }

  // Of triangles by their area, and across lines, so that these keep their course.
  void add_planes() {
    constexpr double kLineWeight = 4;
    quadrics_.resize(positions_.size());
    for (std::int32_t h = 0; h < std::ssize(wedge_of_); ++h) {
      const std::int32_t a = mesh_->start(h), b = mesh_->end(h);
      const glm::dvec3 normal = normal_of(mesh_->triangle(h / 3));
      const double length = glm::length(normal);
      if (length == 0) continue;
      quadrics_[a].add_plane(normal / length, positions_[a], length / 2);
      if (is_line_[h] == 0) continue;
      const glm::dvec3 edge = positions_[b] - positions_[a];
      const double squared = glm::dot(edge, edge);
      if (squared == 0) continue;
      const glm::dvec3 across = glm::normalize(glm::cross(edge, normal));
      quadrics_[a].add_plane(across, positions_[a], kLineWeight * squared);
      quadrics_[b].add_plane(across, positions_[a], kLineWeight * squared);
    }
  }

  [[nodiscard]] glm::dvec3 normal_of(const Triangle& t) const {
    const auto& at = positions_;
    return glm::cross(at[t[1]] - at[t[0]], at[t[2]] - at[t[0]]);
  }

  // Edges of no cost go by their length, and given vertices after others.
  [[nodiscard]] double cost_of(std::int32_t vertex, std::int32_t target) const {
    constexpr double kLengthWeight = 1e-8, kGivenWeight = 2;
    const Quadric& quadric = quadrics_[vertex];
    const double error = quadric.at(positions_[target]);
    if (error > quadric.weight * limit_ * limit_) return kNever;
    const glm::dvec3 edge = positions_[target] - positions_[vertex];
    const double cost = error + kLengthWeight * quadric.weight * glm::dot(edge, edge);
    return is_given_[vertex] != 0 ? kGivenWeight * cost : cost;
  }

  [[nodiscard]] bool is_line(std::size_t i) const {
    return i == fan_.spokes.size() || is_line_[fan_.spokes[i]] != 0;
  }

  // Fills fan_, lines_ and candidates_, these in order.
  void list_candidates(std::int32_t vertex) {
    candidates_.clear();
    lines_.clear();
    if (is_locked_[vertex] != 0) return;
    mesh_->get_fan(vertex, fan_);
    for (std::size_t i = 0; i < fan_.ring.size(); ++i)
      if (is_line(i)) lines_.push_back(i);
    if (lines_.size() != 0 && lines_.size() != 2) return;
    for (std::size_t i = 0; i < fan_.ring.size(); ++i) {
      if (!lines_.empty() && i != lines_[0] && i != lines_[1]) continue;
      if (const double cost = cost_of(vertex, fan_.ring[i]); cost != kNever)
        candidates_.push_back({cost, i});
    }
    std::ranges::sort(candidates_, {}, &Candidate::order);
  }

  void push(std::int32_t vertex) {
    list_candidates(vertex);
    ++waiting_[vertex];
    if (!candidates_.empty()) queue_.push({candidates_[0].cost, vertex, waiting_[vertex]});
  }

  // Of the targets that cost at least as much as the entry: the cheaper ones were in vain.
  void collapse_best(const Entry& entry) {
    ++waiting_[entry.vertex];
    list_candidates(entry.vertex);
    for (const auto& [cost, target] : candidates_) {
      if (cost < entry.cost) continue;
      if (!queue_.empty() && cost > queue_.top().cost) {
        queue_.push({cost, entry.vertex, waiting_[entry.vertex]});
        return;
      }
      if (!may_collapse(entry.vertex, target)) continue;
      apply(entry.vertex, target);
      return;
    }
  }

  [[nodiscard]] bool is_dropped(std::size_t spoke, std::size_t target) const {
    const std::size_t count = fan_.ring.size();
    return spoke == target || (spoke + 1) % count == target;
  }

  bool may_collapse(std::int32_t vertex, std::size_t target) {
    constexpr std::size_t kMostRing = 64;
    const std::size_t count = fan_.ring.size();
    if (count > kMostRing || !mesh_->can_collapse(vertex, fan_, target)) return false;
    // Else two lines would become one.
    for (const std::size_t line : lines_) {
      const std::size_t apart = (line + count - target) % count;
      if (fan_.closed && line != target && (apart == 1 || apart == count - 1)) return false;
    }
    return keeps_shape(vertex, target);
  }

  // Height over the longest side, squared.
  [[nodiscard]] double flatness(const Triangle& t) const {
    const auto side = [&](std::size_t k) {
      const glm::dvec3 edge = positions_[t[(k + 1) % 3]] - positions_[t[k]];
      return glm::dot(edge, edge);
    };
    const double longest = std::max({side(0), side(1), side(2)});
    const glm::dvec3 normal = normal_of(t);
    return longest > 0 ? glm::dot(normal, normal) / (longest * longest) : 0;
  }
  // Least cosine between the triangle's normal and the surface's at its corners. `h`: one of its
  // half-edges, at which the wedge is another.
  [[nodiscard]] double facing(const glm::dvec3& normal, std::int32_t h, std::int32_t wedge) const {
    double least = 1;
    for (const std::int32_t at :
         {wedge, wedge_of_[next_half_edge(h)], wedge_of_[previous_half_edge(h)]})
      least = std::min(least, glm::dot(normal, glm::dvec3(normal_at(at))));
    return least;
  }
  [[nodiscard]] const glm::vec3& normal_at(std::int32_t wedge) const {
    return rows_.normals[wedges_.all()[wedge].row];
  }

  // New triangles face as the surface does, and as the old ones did, and are not thinner.
  [[nodiscard]] bool keeps_shape(std::int32_t vertex, std::size_t target) const {
    constexpr double kLeastFacing = 0.3, kLeastTurn = 0.2, kLeastFlatness = 1e-4;
    const std::int32_t other = fan_.ring[target];
    double flattest = 1;
    for (const std::int32_t spoke : fan_.spokes)
      flattest = std::min(flattest, flatness(mesh_->triangle(spoke / 3)));
    for (std::size_t i = 0; i < fan_.spokes.size(); ++i) {
      if (is_dropped(i, target)) continue;
      const std::int32_t spoke = fan_.spokes[i];
      const Triangle before{vertex, fan_.ring[i], fan_.ring[(i + 1) % fan_.ring.size()]};
      const Triangle after{other, before[1], before[2]};
      if (flatness(after) < std::min(kLeastFlatness, flattest)) return false;
      const glm::dvec3 was = normal_of(before), is = normal_of(after);
      const double was_long = glm::length(was), is_long = glm::length(is);
      if (is_long == 0) return false;
      if (glm::dot(was, is) < kLeastTurn * was_long * is_long) return false;
      const double least =
          was_long > 0 ? std::min(kLeastFacing, facing(was / was_long, spoke, wedge_of_[spoke]))
                       : kLeastFacing;
      if (facing(is / is_long, spoke, new_wedge(i, target)) < least) return false;
    }
    return true;
  }

  // Of the triangle of a spoke that stays, at the target: that of the side of the lines on which it
  // lies.
  [[nodiscard]] std::int32_t new_wedge(std::size_t spoke, std::size_t target) const {
    const std::size_t count = fan_.ring.size();
    const auto after = [&] { return wedge_of_[next_half_edge(fan_.spokes[target])]; };
    const auto before = [&] {
      return wedge_of_[previous_half_edge(fan_.spokes[(target + count - 1) % count])];
    };
    if (!fan_.closed) return target == 0 ? after() : before();
    if (lines_.empty()) return after();
    const std::size_t other = lines_[0] == target ? lines_[1] : lines_[0];
    const std::size_t way = (spoke + count - target) % count;
    return way < (other + count - target) % count ? after() : before();
  }

  void apply(std::int32_t vertex, std::size_t target) {
    const std::int32_t other = fan_.ring[target];
    moved_.clear();
    for (std::size_t i = 0; i < fan_.spokes.size(); ++i) {
      const std::int32_t spoke = fan_.spokes[i];
      if (!is_dropped(i, target)) {
        moved_.emplace_back(spoke, new_wedge(i, target));
        continue;
      }
      --count_;
      // The edge beyond becomes that of the target with the third corner.
      const std::int32_t kept = next_half_edge(spoke);
      const std::int32_t merged = mesh_->twin(i == target ? previous_half_edge(spoke) : spoke);
      if (merged >= 0) is_line_[merged] = is_line_[kept];
    }
    mesh_->collapse(vertex, fan_, target);
    for (const auto& [spoke, wedge] : moved_) wedge_of_[spoke] = wedge;
    quadrics_[other].add(quadrics_[vertex]);
    ring_ = fan_.ring;
    for (const std::int32_t v : ring_)
      if (mesh_->is_used(v)) push(v);
  }

  const Wedges& wedges_;
  const SurfaceMesh& rows_;
  double limit_;
  std::int64_t count_;                 // of triangles
  std::vector<glm::dvec3> positions_;  // by vertex, as the next
  std::vector<std::uint8_t> is_locked_, is_given_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> waiting_;  // versions: entries of older ones are stale
  std::unique_ptr<CollapseMesh> mesh_;
  std::vector<std::int32_t> wedge_of_;  // by half-edge, where it starts
  std::vector<std::uint8_t> is_line_;   // by half-edge, the same of both sides
  std::priority_queue<Entry> queue_;
  // Used again from step to step.
  Fan fan_;
  std::vector<std::size_t> lines_;  // of the fan's ring
  std::vector<Candidate> candidates_;
  std::vector<std::pair<std::int32_t, std::int32_t>> moved_;  // half-edges, wedges
  std::vector<std::int32_t> ring_;
};

class Decimation {
 public:
  Decimation(const AdaptiveSurface& samples, double diagonal)
      : samples_(samples), wedges_(samples), diagonal_(diagonal) {}

  [[nodiscard]] std::int64_t sample_count() const { return samples_.mesh.face_count(); }

  /// At most so many triangles, about within a distance of the diagonal: that is no bound.
  [[nodiscard]] AdaptiveSurface at_most(std::int64_t triangles, double distance) const {
    Collapses collapses(samples_.mesh, wedges_, distance * diagonal_);
    collapses.run(triangles);
    return surface_of(collapses.corners());
  }

  /// The largest distance from the samples' triangles and to them, in diagonals.
  [[nodiscard]] double distance(const AdaptiveSurface& made) const {
    const SurfaceMesh &coarse = made.mesh, &fine = samples_.mesh;
    const std::vector<Triangle> triangles = triangles_of(coarse);
    const PointDistances to = measure_distances(fine.positions, coarse.positions, triangles);
    const PointDistances back =
        measure_distances(middles_of(coarse), fine.positions, triangles_of(fine));
    return std::max(to.max, back.max) / diagonal_;
  }

 private:
  [[nodiscard]] AdaptiveSurface surface_of(std::span<const std::int32_t> corners) const;

  const AdaptiveSurface& samples_;
  Wedges wedges_;
  double diagonal_;
};

AdaptiveSurface Decimation::surface_of(std::span<const std::int32_t> corners) const {
  AdaptiveSurface made = samples_;
  SurfaceMesh& mesh = made.mesh;
  const std::size_t count = corners.size() / 3;
  mesh.face_offsets.resize(count + 1);
  mesh.face_vertices.resize(corners.size());
  if (!mesh.face_uvs.empty()) mesh.face_uvs.resize(corners.size());
  if (!mesh.face_groups.empty()) mesh.face_groups.resize(count);
  made.ancestors.resize(count);
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const auto& wedge = wedges_.all()[corners[c]];
    mesh.face_vertices[c] = wedge.row;
    if (!mesh.face_uvs.empty()) mesh.face_uvs[c] = wedge.uv;
    if (c % 3 > 0) continue;
    if (!mesh.face_groups.empty()) mesh.face_groups[c / 3] = wedge.group;
    made.ancestors[c / 3] = wedge.ancestor;
  }
  drop_unnamed(made, 0, 0);
  return made;
}

// `before`: how many have been made.
AdaptiveSurface samples_within(const LimitSurface& surface, const DecimateOptions& options,
                               double chord_error, int before) {
  const auto half_done = [](int made) { return 0.5 - std::ldexp(0.5, -made); };
  AdaptiveSurface samples = tessellate(
      surface,
      {.chord_error = chord_error,
       .diagonal = options.diagonal,
       .memory_limit_bytes = options.memory_limit_bytes,
       .callbacks = share_of(options.callbacks, half_done(before), half_done(before + 1))});
  const std::uint64_t limit =
      options.memory_limit_bytes > 0 ? options.memory_limit_bytes : available_memory_bytes();
  const auto triangles = static_cast<std::uint64_t>(samples.mesh.face_count());
  if (kTriangleBytes * triangles <= limit) return samples;
  throw Error(ErrorCode::OutOfMemory,
              formatted("to take few of {} triangles needs {} MiB of memory where {} are free; "
                        "allow a larger distance, or want fewer triangles",
                        triangles, kTriangleBytes * triangles >> 20, limit >> 20));
}

std::int64_t wanted_triangles(const DecimationTarget& target, const SurfaceMesh& samples) {
  if (target.edge_length == 0) return target.triangles;
  const double each = std::numbers::sqrt3 / 4 * target.edge_length * target.edge_length;
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int64_t>(std::clamp(area_of(samples) / each, 1.0, kMost));
}

// Few samples on what is flat, as many as it takes elsewhere: their number grows about as the chord
// error falls.
AdaptiveSurface samples_for(const LimitSurface& surface, const DecimateOptions& options) {
  double chord_error = kFirstChordError;
  for (int made = 0;; ++made) {
    AdaptiveSurface samples = samples_within(surface, options, chord_error, made);
    const auto count = static_cast<double>(samples.mesh.face_count());
    const double enough =
        kFiner * static_cast<double>(wanted_triangles(options.target, samples.mesh));
    if (count >= enough || chord_error <= kLeastChordError) return samples;
    const double share = std::clamp(0.8 * count / enough, 1.0 / 16, 0.5);
    chord_error = std::max(kLeastChordError, share * chord_error);
  }
}

DecimatedSurface to_triangles(const LimitSurface& surface, const DecimateOptions& options) {
  AdaptiveSurface samples = samples_for(surface, options);
  const std::int64_t wanted = wanted_triangles(options.target, samples.mesh);
  const Callbacks callbacks = share_of(options.callbacks, 0.5, 1);
  callbacks.report("decimate", 0);
  const Decimation decimation(samples, options.diagonal);
  DecimatedSurface made{decimation.at_most(wanted, std::numeric_limits<double>::infinity()), {}};
  callbacks.report("decimate", 0.5);
  made.figures = figures_of(made.surface, samples, surface, options.diagonal);
  made.figures.wanted = wanted;
  const std::int64_t count = made.surface.mesh.face_count();
  if (count > wanted)
    options.callbacks.warn(
        {.code = kTrianglesNotReached,
         .message = formatted(
             "{} triangles are wanted, and {} are the fewest that keep borders, sharp edges, seams "
             "of the texture and edges of materials; want more, or join parts before",
             wanted, count),
         .count = count - wanted});
  return made;
}

// The largest limit of collapses that keeps the distance, about.
DecimatedSurface to_distance(const LimitSurface& surface, const DecimateOptions& options) {
  constexpr int kTries = 7;
  const double distance = options.target.distance;
  const double allowed = (1 - kSampleShare) * distance;
  AdaptiveSurface samples = samples_within(surface, options, kSampleShare * distance, 0);
  const Callbacks callbacks = share_of(options.callbacks, 0.5, 1);
  const Decimation decimation(samples, options.diagonal);
  std::optional<AdaptiveSurface> best;
  double low = 0, high = std::numeric_limits<double>::infinity(), limit = allowed;
  for (int i = 0; i < kTries; ++i) {
    callbacks.report("decimate", static_cast<double>(i) / kTries);
    AdaptiveSurface made = decimation.at_most(1, limit);
    const double measured = decimation.distance(made);
    if (measured <= allowed) {
      low = limit;
      if (!best || made.mesh.face_count() < best->mesh.face_count()) best = std::move(made);
      if (measured > 0.9 * allowed) break;
    } else {
      high = limit;
    }
    limit = std::isinf(high) ? 2 * low : low > 0 ? std::sqrt(low * high) : high / 3;
  }
  if (!best) best = samples;
  const DecimationFigures figures = figures_of(*best, samples, surface, options.diagonal);
  return {*std::move(best), figures};
}

}  // namespace

DecimatedSurface decimate(const LimitSurface& surface, const DecimateOptions& options) {
  require_target(options);
  const HostScope host(options.callbacks);
  DecimatedSurface made =
      options.target.distance > 0 ? to_distance(surface, options) : to_triangles(surface, options);
  options.callbacks.report("decimate", 1);
  return made;
}

}  // namespace planish
