#include "planish/quads/pair_triangles.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/group_by.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {
namespace {

// Radians: angles that differ by less are the same; rounding does not decide between them.
constexpr double kAsGood = 1e-6;

// What makes a good quad of two triangles.
class QuadRule {
 public:
  explicit QuadRule(const PairOptions& options);

  // Largest deviation of a corner from a right angle, in radians; none for a quad that may not be.
  [[nodiscard]] std::optional<double> badness_of(std::span<const glm::dvec3> positions,
                                                 const std::array<std::int32_t, 4>& quad) const;

 private:
  double least_cosine_, largest_angle_;
  double widest_;  // the tangent of that angle's deviation from a right one
};

QuadRule::QuadRule(const PairOptions& options)
    : least_cosine_(portable::cos(options.largest_turn * (std::numbers::pi / 180) + kAsGood)),
      largest_angle_(options.largest_angle * (std::numbers::pi / 180) + kAsGood),
      widest_(portable::tan(largest_angle_ - std::numbers::pi / 2)) {}

// Tangents tell the corners whose angle counts.
std::optional<double> QuadRule::badness_of(std::span<const glm::dvec3> positions,
                                           const std::array<std::int32_t, 4>& quad) const {
  constexpr double kRounding = 1e-9;
  const auto place = [&](std::size_t i) -> const glm::dvec3& { return positions[quad[i % 4]]; };
  const glm::dvec3 diagonal = place(2) - place(0);
  const glm::dvec3 n0 = glm::cross(place(1) - place(0), diagonal);
  const glm::dvec3 n1 = glm::cross(diagonal, place(3) - place(0));
  const double lengths = glm::length(n0) * glm::length(n1);
  if (!(lengths > 0) || glm::dot(n0, n1) < lengths * least_cosine_) return std::nullopt;
  const glm::dvec3 normal = n0 + n1;
  // The tangents are those of the deviations: above 0 of wide corners.
  std::array<double, 4> sines, cosines, tangents;
  double steepest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 ahead = place(i + 1) - place(i), back = place(i + 3) - place(i);
    const glm::dvec3 cross = glm::cross(ahead, back);
    if (!(glm::dot(cross, normal) > 0)) return std::nullopt;
    sines[i] = glm::length(cross);
    cosines[i] = glm::dot(ahead, back);
    tangents[i] = -cosines[i] / sines[i];
    steepest = std::max(steepest, std::abs(tangents[i]));
  }
  double worst = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const bool may_be_wide = tangents[i] >= widest_ - kRounding * (1 + std::abs(widest_));
    if (!may_be_wide && std::abs(tangents[i]) < (1 - kRounding) * steepest) continue;
    const double angle = portable::atan2(sines[i], cosines[i]);
    if (angle > largest_angle_) return std::nullopt;
    worst = std::max(worst, std::abs(angle - std::numbers::pi / 2));
  }
  return worst;
}

// Badness that says that two triangles may be no pair.
constexpr double kNoPair = -1;

// Pairs of neighbouring triangles, by their badness alone: the order of triangles decides nothing.
// Of quads that share triangles and are as good all are joined that one matching asks for, or
// none: triangles of an even fan have two such matchings, of an odd one none.
class TrianglePairing {
 public:
  // `twins` by half-edge, three a triangle, -1 where there is none; `badness` in radians by
  // half-edge, kNoPair where there may be no pair.
  TrianglePairing(std::span<const std::int32_t> twins, std::vector<double> badness);

  // A triangle's half-edge to its partner; -1: none.
  [[nodiscard]] std::span<const std::int32_t> chosen() const { return chosen_; }

  // The least bad first.
  void pair_greedily();

  // Triangles left alone are joined by exchanging at most so many pairs, by pairs of at most that
  // badness, the cheapest exchange first.
  void exchange(int most, double worst);

 private:
  std::span<const std::int32_t> twins_;
  std::vector<double> badness_;
  std::vector<std::int32_t> chosen_;
  std::vector<std::int32_t> tied_, waiting_;  // half-edges, triangles
  std::vector<char> is_tied_;                 // by half-edge
  std::vector<std::int32_t> path_, passed_;   // half-edges to join; triangles

  // Half-edges to join, ascending, the lesser of each two twins; `is_only`: none other costs as
  // little.
  struct Exchange {
    double cost = 0;
    std::vector<std::int32_t> joins;
    bool is_only = true;
  };

  [[nodiscard]] bool is_free(std::int32_t half_edge) const {
    return badness_[half_edge] != kNoPair && chosen_[half_edge / 3] < 0 &&
           chosen_[twins_[half_edge] / 3] < 0;
  }
  void join(std::int32_t half_edge);
  void find_ties(std::int32_t half_edge);
  void join_ties();
  [[nodiscard]] bool join_from_ends(std::vector<std::int32_t>& joined);
  [[nodiscard]] int partners(std::int32_t triangle) const;
  [[nodiscard]] bool join_cheapest(std::vector<Exchange>& found, std::vector<std::int32_t>& claims);
  void search(std::int32_t triangle, int exchanges, double cost, double worst, Exchange& best);
};

// Based on: C. Berge, "Two Theorems in Graph Theory", 1957 (a matching grows along a path that
// leaves and enters its pairs in turn).

// The half-edges of a triangle.
std::array<std::int32_t, 3> sides_of(std::int32_t triangle) {
  return {3 * triangle, 3 * triangle + 1, 3 * triangle + 2};
}

TrianglePairing::TrianglePairing(std::span<const std::int32_t> twins, std::vector<double> badness)
    : twins_(twins),
      badness_(std::move(badness)),
      chosen_(twins.size() / 3, -1),
      is_tied_(twins.size(), 0) {}

void TrianglePairing::join(std::int32_t half_edge) {
  chosen_[half_edge / 3] = half_edge;
  chosen_[twins_[half_edge] / 3] = twins_[half_edge];
}

void TrianglePairing::pair_greedily() {
  const auto leads = [&](std::int32_t h) { return badness_[h] != kNoPair && h < twins_[h]; };
  const SelectedBlocks blocks = count_selected(twins_.size(), leads);
  std::vector<std::pair<double, std::int32_t>> order(static_cast<std::size_t>(blocks.total));
  for_selected(twins_.size(), blocks, leads, [&](std::size_t h, std::int32_t number) {
    order[number] = {badness_[h], static_cast<std::int32_t>(h)};
  });
  oneapi::tbb::parallel_sort(order.begin(), order.end());
  for (const auto& [badness, h] : order) {
    if (!is_free(h)) continue;
    find_ties(h);
    if (tied_.size() == 1)
      join(h);
    else
      join_ties();
    for (const std::int32_t tied : tied_) is_tied_[tied] = is_tied_[twins_[tied]] = 0;
  }
}

// Those that are as good and hang together by triangles, each once.
void TrianglePairing::find_ties(std::int32_t half_edge) {
  const double badness = badness_[half_edge];
  tied_.clear();
  const auto add = [&](std::int32_t h) {
    tied_.push_back(h);
    is_tied_[h] = is_tied_[twins_[h]] = 1;
  };
  add(half_edge);
  for (std::size_t i = 0; i < tied_.size(); ++i)
    for (const std::int32_t own : {tied_[i], twins_[tied_[i]]})
      for (const std::int32_t h : sides_of(own / 3))
        if (!is_tied_[h] && is_free(h) && std::abs(badness_[h] - badness) <= kAsGood) add(h);
}

int TrianglePairing::partners(std::int32_t triangle) const {
  return static_cast<int>(std::ranges::count_if(
      sides_of(triangle), [&](std::int32_t h) { return is_tied_[h] && is_free(h); }));
}

// All that are tied, or none: then they may be no pairs any more.
void TrianglePairing::join_ties() {
  std::vector<std::int32_t> joined;
  if (join_from_ends(joined)) return;
  for (const std::int32_t h : joined) chosen_[h / 3] = chosen_[twins_[h] / 3] = -1;
  for (const std::int32_t h : tied_) badness_[h] = badness_[twins_[h]] = kNoPair;
}

// From triangles with one partner inwards. False where that leaves one alone, or none has only one.
bool TrianglePairing::join_from_ends(std::vector<std::int32_t>& joined) {
  waiting_.clear();
  for (const std::int32_t h : tied_)
    for (const std::int32_t t : {h / 3, twins_[h] / 3})
      if (partners(t) == 1) waiting_.push_back(t);
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const std::int32_t t = waiting_[i];
    if (chosen_[t] >= 0) continue;
    const auto sides = sides_of(t);
    const auto side =
        std::ranges::find_if(sides, [&](std::int32_t h) { return is_tied_[h] && is_free(h); });
    if (side == sides.end()) return false;
    join(*side);
    joined.push_back(*side);
    for (const std::int32_t g : sides_of(twins_[*side] / 3)) {
      const std::int32_t beyond = is_tied_[g] ? twins_[g] / 3 : t;
      if (chosen_[beyond] >= 0) continue;
      const int left = partners(beyond);
      if (left == 0) return false;
      if (left == 1) waiting_.push_back(beyond);
    }
  }
  return std::ranges::none_of(tied_, [&](std::int32_t h) { return is_free(h); });
}

void TrianglePairing::exchange(int most, double worst) {
  std::vector<std::int32_t> alone;
  for (std::size_t t = 0; t < chosen_.size(); ++t)
    if (chosen_[t] < 0) alone.push_back(static_cast<std::int32_t>(t));
  std::vector<std::int32_t> claims(chosen_.size());
  while (!alone.empty()) {
    std::vector<Exchange> found;
    for (const std::int32_t t : alone) {
      Exchange best{std::numeric_limits<double>::infinity(), {}, true};
      search(t, most, 0, worst, best);
      if (best.joins.empty() || !best.is_only) continue;
      for (std::int32_t& h : best.joins) h = std::min(h, twins_[h]);
      std::ranges::sort(best.joins);
      found.push_back(std::move(best));
    }
    if (!join_cheapest(found, claims)) return;
    std::erase_if(alone, [&](std::int32_t t) { return chosen_[t] >= 0; });
  }
}

// The cheapest first; of those that cost as much and want the same triangles none. Whether any was
// made.
bool TrianglePairing::join_cheapest(std::vector<Exchange>& found,
                                    std::vector<std::int32_t>& claims) {
  constexpr std::int32_t kUnclaimed = -1, kTaken = -2;
  std::ranges::sort(found, [](const Exchange& a, const Exchange& b) {
    return std::pair(a.cost, std::span(a.joins).front()) <
           std::pair(b.cost, std::span(b.joins).front());
  });
  std::ranges::fill(claims, kUnclaimed);
  const auto all_ends = [&](const Exchange& exchange, const auto& holds) {
    return std::ranges::all_of(exchange.joins, [&](std::int32_t h) {
      return holds(claims[h / 3]) && holds(claims[twins_[h] / 3]);
    });
  };
  bool has_joined = false;
  for (std::size_t first = 0, last = 0; first < found.size(); first = last) {
    // Each is found from both of its ends.
    std::vector<std::int32_t> group;
    for (; last < found.size() && found[last].cost <= found[first].cost + kAsGood; ++last) {
      const auto is_same = [&](std::int32_t g) { return found[g].joins == found[last].joins; };
      const bool is_open =
          all_ends(found[last], [](std::int32_t claim) { return claim != kTaken; });
      if (is_open && std::ranges::none_of(group, is_same))
        group.push_back(static_cast<std::int32_t>(last));
    }
    std::vector<char> is_wanted(group.size(), 1);
    for (std::size_t i = 0; i < group.size(); ++i)
      for (const std::int32_t h : found[group[i]].joins)
        for (std::int32_t* const claim : {&claims[h / 3], &claims[twins_[h] / 3]}) {
          if (*claim >= 0 && *claim != static_cast<std::int32_t>(i))
            is_wanted[*claim] = is_wanted[i] = 0;
          else
            *claim = static_cast<std::int32_t>(i);
        }
    for (std::size_t i = 0; i < group.size(); ++i)
      for (const std::int32_t h : found[group[i]].joins) {
        claims[h / 3] = claims[twins_[h] / 3] = is_wanted[i] ? kTaken : kUnclaimed;
        if (is_wanted[i]) join(h);
        has_joined |= is_wanted[i] != 0;
      }
  }
  return has_joined;
}

// Continues path_ from a triangle that has lost its partner, or has none.
void TrianglePairing::search(std::int32_t triangle, int exchanges, double cost, double worst,
                             Exchange& best) {
  passed_.push_back(triangle);
  for (const std::int32_t h : sides_of(triangle)) {
    if (badness_[h] == kNoPair || badness_[h] > worst + kAsGood || h == chosen_[triangle]) continue;
    const std::int32_t next = twins_[h] / 3;
    if (std::ranges::find(passed_, next) != passed_.end()) continue;
    path_.push_back(h);
    const std::int32_t left = chosen_[next];
    if (left < 0) {
      const double whole = cost + badness_[h];
      if (whole < best.cost - kAsGood)
        best = {whole, path_, true};
      else if (whole < best.cost + kAsGood)
        best.is_only = false;
    } else if (exchanges > 0) {
      passed_.push_back(next);
      search(twins_[left] / 3, exchanges - 1, cost + badness_[h] - badness_[left], worst, best);
      passed_.pop_back();
    }
    path_.pop_back();
  }
  passed_.pop_back();
}

constexpr double kDegree = std::numbers::pi / 180;
// Most pairs that are exchanged to pair two triangles more, and the largest deviation from a right
// angle of what comes in: pairs by exchange are worse quads, and where their corners are wider than
// 130 degrees the progressive surface folds on a third more of its area.
constexpr int kMostExchanges = 2;
constexpr double kWorstExchanged = 40 * kDegree;
// Of vertices that tell of halved quads: most that are looked at, and a turn that is none.
constexpr std::int32_t kMostLookedAt = 1000;
constexpr double kFlat = 1e-3;

// a, d, b, c for the edge a b with the opposite corners c and d.
std::array<std::int32_t, 4> quad_of(std::span<const Triangle> triangles, std::int32_t half_edge,
                                    std::int32_t twin) {
  const auto start = [&](std::int32_t h) { return triangles[h / 3][h % 3]; };
  return {start(half_edge), start(previous_half_edge(twin)), start(twin),
          start(previous_half_edge(half_edge))};
}

// For each half-edge how bad the quad is that loses it. `twins`: -1 where none may be lost.
std::vector<double> badness_of(std::span<const glm::dvec3> positions,
                               std::span<const Triangle> triangles,
                               std::span<const std::int32_t> twins, const PairOptions& options) {
  const QuadRule rule(options);
  std::vector<double> badness(twins.size(), kNoPair);
  parallel_each(twins.size(), [&](std::int32_t h) {
    if (twins[h] < h) return;
    const auto found = rule.badness_of(positions, quad_of(triangles, h, twins[h]));
    if (found) badness[h] = badness[twins[h]] = *found;
  });
  return badness;
}

// For each triangle the half-edge that it loses; -1: none.
std::vector<std::int32_t> lost_half_edges(std::span<const std::int32_t> twins,
                                          const std::vector<double>& badness) {
  TrianglePairing pairing(twins, badness);
  pairing.pair_greedily();
  for (int most = 1; most <= kMostExchanges; ++most) pairing.exchange(most, kWorstExchanged);
  return {pairing.chosen().begin(), pairing.chosen().end()};
}

// A mesh's triangles among its faces, numbered by themselves.
struct TrianglesOf {
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> faces;    // of the mesh, by triangle
  std::vector<std::int32_t> of_face;  // and back; -1: the face is no triangle
  std::vector<std::int32_t> twins;    // by half-edge; -1 where the edge has to stay
};

class Borders {
 public:
  Borders(const PolygonMesh& mesh, const PreparedMesh& prepared)
      : mesh_(mesh), is_tagged_(static_cast<std::size_t>(prepared.topology->edge_count()), 0) {
    const MeshTopology& topology = *prepared.topology;
    const auto number_of = [&](std::int32_t vertex) {
      if (prepared.uses_all()) return vertex;
      const auto found = std::ranges::lower_bound(prepared.vertices, vertex);
      const bool is_used = found != prepared.vertices.end() && *found == vertex;
      return is_used ? static_cast<std::int32_t>(found - prepared.vertices.begin()) : -1;
    };
    for (const CreaseEdge& crease : mesh.creases) {
      const std::int32_t a = number_of(crease.v0), b = number_of(crease.v1);
      const std::int32_t edge = a < 0 || b < 0 ? -1 : topology.find_edge(a, b);
      if (edge >= 0) is_tagged_[edge] = 1;
    }
    if (!mesh.hole_faces.empty()) is_hole_ = hole_flags(mesh);
  }

  // Whether the leading edge of a corner, which is that of `twin` too, has to stay.
  [[nodiscard]] bool has(const MeshTopology& topology, std::int32_t corner,
                         std::int32_t twin) const {
    const std::int32_t face = topology.face_of(corner), other = topology.face_of(twin);
    if (is_tagged_[topology.edge_of(corner)] != 0) return true;
    if (!mesh_.face_groups.empty() && mesh_.face_groups[face] != mesh_.face_groups[other])
      return true;
    if (!is_hole_.empty() && is_hole_[face] != is_hole_[other]) return true;
    const auto& uvs = mesh_.face_uvs;
    return !uvs.empty() &&
           (uvs[corner] != uvs[topology.next(twin)] || uvs[topology.next(corner)] != uvs[twin]);
  }

 private:
  const PolygonMesh& mesh_;
  std::vector<std::uint8_t> is_tagged_, is_hole_;
};

TrianglesOf triangles_of(const PolygonMesh& mesh, const PreparedMesh& prepared,
                         std::span<const std::uint8_t> may_join = {}) {
  const MeshTopology& topology = *prepared.topology;
  const Borders borders(mesh, prepared);
  TrianglesOf own;
  const auto face_count = static_cast<std::size_t>(mesh.face_count());
  const auto is_triangle = [&](std::int32_t f) {
    return mesh.face_size(f) == 3 && (may_join.empty() || may_join[f] != 0);
  };
  const SelectedBlocks blocks = count_selected(face_count, is_triangle);
  own.of_face.assign(face_count, -1);
  own.triangles.resize(static_cast<std::size_t>(blocks.total));
  own.faces.resize(own.triangles.size());
  for_selected(face_count, blocks, is_triangle, [&](std::size_t f, std::int32_t number) {
    const auto face = mesh.face(static_cast<std::int32_t>(f));
    own.of_face[f] = number;
    own.triangles[number] = {face[0], face[1], face[2]};
    own.faces[number] = static_cast<std::int32_t>(f);
  });
  own.twins.assign(3 * own.triangles.size(), -1);
  parallel_each(own.twins.size(), [&](std::size_t h) {
    const std::int32_t corner =
        mesh.face_offsets[own.faces[h / 3]] + static_cast<std::int32_t>(h % 3);
    const std::int32_t twin = topology.twin(corner);
    const std::int32_t other = twin < 0 ? -1 : own.of_face[topology.face_of(twin)];
    if (other >= 0 && !borders.has(topology, corner, twin))
      own.twins[h] = 3 * other + topology.place_of(twin);
  });
  return own;
}

// Takes pairs back that would leave a vertex inside the mesh with two faces, which lie on each
// other: the worst of its pairs, and those that are as good.
void keep_three_faces(const TrianglesOf& own, const PolygonMesh& mesh, const PreparedMesh& prepared,
                      std::span<const double> badness, std::vector<std::int32_t>& lost) {
  const MeshTopology& topology = *prepared.topology;
  const auto pairs_at = group_by<std::int32_t>(mesh.positions.size(), [&](const auto& take) {
    for (std::size_t t = 0; t < lost.size(); ++t) {
      const std::int32_t h = lost[t];
      if (h < 0 || own.twins[h] < h) continue;
      take(own.triangles[t][h % 3], h);
      take(own.triangles[t][next_half_edge(h) % 3], h);
    }
  });
  std::vector<std::int32_t> pairs;
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    const std::int32_t vertex = prepared.vertices[v];
    const auto faces = static_cast<std::int32_t>(topology.corners_at(v).size());
    const auto spare =
        static_cast<std::size_t>(std::max(0, faces - (topology.is_boundary_vertex(v) ? 1 : 3)));
    const std::span<const std::int32_t> at = pairs_at.of(vertex);
    if (at.size() <= spare) continue;
    pairs.assign(at.begin(), at.end());
    std::ranges::sort(pairs, {}, [&](std::int32_t h) { return badness[h]; });
    const double bar = badness[pairs[spare]] - kAsGood;
    for (const std::int32_t h : pairs)
      if (badness[h] > bar) lost[h / 3] = lost[own.twins[h] / 3] = -1;
  }
}

// Adds a face of corners of the source, with what rides on them.
void add_corners(const PolygonMesh& source, std::span<const std::int32_t> corners,
                 PairedMesh& result) {
  PolygonMesh& mesh = result.mesh;
  for (const std::int32_t corner : corners) {
    mesh.face_vertices.push_back(source.face_vertices[corner]);
    if (!source.face_uvs.empty()) mesh.face_uvs.push_back(source.face_uvs[corner]);
  }
  mesh.face_offsets.push_back(static_cast<std::int32_t>(mesh.face_vertices.size()));
}

// The half-edge that a triangle would lose first; -1: none, or two are as good.
std::int32_t first_choice(const TrianglesOf& own, std::span<const glm::dvec3> positions,
                          const QuadRule& rule, std::int32_t triangle) {
  std::int32_t best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
    const std::int32_t twin = own.twins[h];
    if (twin < 0) continue;
    const auto badness =
        rule.badness_of(positions, quad_of(own.triangles, std::min(h, twin), std::max(h, twin)));
    if (!badness || *badness > least + kAsGood) continue;
    best = *badness < least - kAsGood ? h : -1;
    least = std::min(least, *badness);
  }
  return best;
}

// By how much the faces turn at the leading edge of a corner inside the mesh, in radians.
double turn_at(const PolygonMesh& mesh, const MeshTopology& topology, std::int32_t corner) {
  const auto normal_of = [&](std::int32_t of) {
    return area_vector(mesh.positions, mesh.face(topology.face_of(of)));
  };
  return angle_between(normal_of(corner), normal_of(topology.twin(corner)));
}

}  // namespace

HalvedVertices halved_vertices(const PolygonMesh& mesh, const PreparedMesh& prepared,
                               const PairOptions& options) {
  const MeshTopology& topology = *prepared.topology;
  HalvedVertices result;
  const TrianglesOf own = triangles_of(mesh, prepared);
  const QuadRule rule(options);
  // Whether both triangles beside the corner's leading edge would lose it first.
  const auto is_lost_first = [&](std::int32_t corner) {
    const std::int32_t t = own.of_face[topology.face_of(corner)];
    if (t < 0) return false;
    const std::int32_t half_edge = 3 * t + topology.place_of(corner);
    const std::int32_t twin = own.twins[half_edge];
    return twin >= 0 && first_choice(own, mesh.positions, rule, t) == half_edge &&
           first_choice(own, mesh.positions, rule, twin / 3) == twin;
  };
  const std::int32_t step = 1 + topology.vertex_count() / kMostLookedAt;
  for (std::int32_t v = 0; v < topology.vertex_count(); v += step) {
    ++result.looked_at;
    if (topology.is_boundary_vertex(v)) continue;
    const auto corners = topology.corners_at(v);
    double turn = 0;
    bool has_flat = false;
    std::int64_t quads = 0, turning = 0;  // faces that are left, and where flat ones are one
    for (const std::int32_t corner : corners) {
      const double own_turn = turn_at(mesh, topology, corner);
      const bool is_lost = is_lost_first(corner);
      turn = std::max(turn, own_turn);
      has_flat |= own_turn < kFlat;
      quads += is_lost ? 0 : 1;
      turning += is_lost || own_turn < kFlat ? 0 : 1;
    }
    if (turn < kFlat || turn > options.largest_turn * kDegree) continue;
    // At the rim of a flat cap it says nothing of what is beside that.
    if (turning == 3 && has_flat) continue;
    ++result.telling;
    if (quads == 4) ++result.regular;
  }
  return result;
}

PolygonMesh pair_triangles(std::span<const glm::dvec3> positions,
                           std::span<const Triangle> triangles, const PairOptions& options) {
  const std::vector<std::int32_t> twins = twins_of(triangles, positions.size());
  const std::vector<std::int32_t> lost =
      lost_half_edges(twins, badness_of(positions, triangles, twins, options));
  PolygonMesh mesh;
  mesh.positions.assign(positions.begin(), positions.end());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (lost[t] < 0) {
      mesh.add_face(triangles[t]);
    } else if (lost[t] < twins[lost[t]]) {
      mesh.add_face(quad_of(triangles, lost[t], twins[lost[t]]));
    }
  }
  return mesh;
}

PairedMesh with_paired_triangles(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                 const PairOptions& options) {
  const TrianglesOf own = triangles_of(mesh, prepared, options.may_join);
  const std::vector<double> badness = badness_of(mesh.positions, own.triangles, own.twins, options);
  std::vector<std::int32_t> lost = lost_half_edges(own.twins, badness);
  keep_three_faces(own, mesh, prepared, badness, lost);
  PairedMesh result;
  PolygonMesh& paired = result.mesh;
  paired = mesh;
  paired.face_offsets = {0};
  for (auto* const lists :
       {&paired.face_vertices, &paired.face_uvs, &paired.face_groups, &paired.hole_faces})
    lists->clear();
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::size_t t = 0;  // the next triangle
  std::vector<std::int32_t> corners;
  const auto corner_of = [&](std::int32_t half_edge) {
    return mesh.face_offsets[own.faces[half_edge / 3]] + half_edge % 3;
  };
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    corners.clear();
    const bool is_triangle = t < own.faces.size() && own.faces[t] == f;
    const std::int32_t half_edge = is_triangle ? lost[t++] : -1;
    if (half_edge < 0) {
      for (std::int32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c)
        corners.push_back(c);
    } else if (const std::int32_t twin = own.twins[half_edge]; half_edge < twin) {
      for (const std::int32_t h :
           {half_edge, previous_half_edge(twin), twin, previous_half_edge(half_edge)})
        corners.push_back(corner_of(h));
      ++result.pair_count;
    } else {
      continue;  // the second half
    }
    if (is_hole[f] != 0) paired.hole_faces.push_back(paired.face_count());
    add_corners(mesh, corners, result);
    if (!mesh.face_groups.empty()) paired.face_groups.push_back(mesh.face_groups[f]);
    result.source_faces.push_back(f);
  }
  return result;
}

}  // namespace planish
