#include "planish/refine/guess_surface.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

constexpr int kQuadric = 5, kImplicit = 8, kCubic = 9;
// Directions that the places leave open, relative to the best known one, are left at 0.
constexpr double kRidge = 1e-8;
// Tangent of half the angle by which faces turn at most where they sample a smooth surface.
constexpr double kSteepest = 0.577;
constexpr int kTurns = 3;
// Places behind 60 degrees of a ball say little of the surface here.
constexpr double kMostStretched = 2;
// Share of the fit at a place that others decide, at least.
constexpr double kLeastOthers = 0.05;
constexpr int kStretchRounds = 4;
// What jets leave in doubt at most that are believed against the faces, and the cosine of the angle
// within which they foretell one another's normals: 15 degrees.
constexpr double kToldDoubt = 0.1, kToldCosine = 0.966;
// Corners that are looked at beside a neighbour's, each way: linear time at hubs.
constexpr int kWalk = 16;

using Coefficients = std::array<double, kCubic>;

// A^T A + ridge, of which the upper half is given, as U^T D^-1 U with D on U's diagonal.
class Normal {
 public:
  Normal(const std::array<Coefficients, kCubic>& matrix, int first, int last)
      : matrix_(matrix), first_(first), last_(last) {
    double trace = 0;
    for (int i = first; i < last; ++i) trace += matrix_[i][i];
    for (int i = first; i < last; ++i) matrix_[i][i] += kRidge * trace + 1e-300;
    for (int k = first; k < last; ++k)
      for (int i = k + 1; i < last; ++i) {
        const double factor = matrix_[k][i] / matrix_[k][k];
        for (int j = i; j < last; ++j) matrix_[i][j] -= factor * matrix_[k][j];
      }
  }

  // Of A^T z.
  [[nodiscard]] Coefficients solve(Coefficients right) const {
    reduce(right);
    for (int i = last_ - 1; i >= first_; --i) {
      for (int j = i + 1; j < last_; ++j) right[i] -= matrix_[i][j] * right[j];
      right[i] /= matrix_[i][i];
    }
    return right;
  }
  // row (A^T A)^-1 row^T
  [[nodiscard]] double leverage(Coefficients row) const {
    reduce(row);
    double sum = 0;
    for (int i = first_; i < last_; ++i) sum += row[i] * row[i] / matrix_[i][i];
    return sum;
  }

 private:
  void reduce(Coefficients& right) const {
    for (int k = first_; k < last_; ++k)
      for (int i = k + 1; i < last_; ++i) right[i] -= matrix_[k][i] / matrix_[k][k] * right[k];
  }

  std::array<Coefficients, kCubic> matrix_;
  int first_, last_;
};

// Of what heights are sums of, see VertexJet; tilts are of the place's foot.
struct Sum {
  double value;
  glm::dvec3 gradient;
};

// `at`: over a jet's axes.
Sum sum_at(const Coefficients& k, bool is_implicit, const glm::dvec3& at) {
  const auto [x, y, z] = std::array{at.x, at.y, at.z};
  const double q = k[2] * x * x / 2 + k[3] * x * y + k[4] * y * y / 2;
  const glm::dvec3 tilt(k[0], k[1], 0), of_q(k[2] * x + k[3] * y, k[3] * x + k[4] * y, 0);
  const double tilted = k[0] * x + k[1] * y;
  if (is_implicit) {
    const glm::dvec3 bend(k[6] * z, k[7] * z, k[5] * z + k[6] * x + k[7] * y);
    return {tilted + q + z * (k[5] * z / 2 + k[6] * x + k[7] * y), tilt + of_q + bend};
  }
  const double flat = x * x + y * y;
  if (!(flat > 0)) return {0, tilt};
  // (x, y) times a stretch s: s^2 q + s^3 c.
  const double c = x * x * (k[5] * x + k[6] * y) + y * y * (k[7] * x + k[8] * y);
  const glm::dvec3 of_c(3 * k[5] * x * x + 2 * k[6] * x * y + k[7] * y * y,
                        k[6] * x * x + 2 * k[7] * x * y + 3 * k[8] * y * y, 0);
  const double square = 1 + z * z / flat;
  const bool is_far = square > kMostStretched * kMostStretched;
  const double s2 = is_far ? kMostStretched * kMostStretched : square, s = std::sqrt(s2);
  const glm::dvec3 of_s2 =
      is_far ? glm::dvec3(0) : 2 / flat * glm::dvec3((1 - s2) * x, (1 - s2) * y, z);
  return {tilted + s2 * q + s * s2 * c,
          tilt + s2 * of_q + s * s2 * of_c + (q + 1.5 * s * c) * of_s2};
}

void set_axes(VertexJet& jet) {
  const glm::dvec3 n = jet.normal;
  jet.e1 = glm::normalize(
      glm::cross(n, std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  jet.e2 = glm::cross(n, jet.e1);
}

class JetFitter {
 public:
  JetFitter(std::span<const glm::dvec3> positions, const MeshTopology& topology,
            std::span<const char> is_sharp)
      : positions_(positions),
        topology_(topology),
        is_sharp_(is_sharp),
        normals_(positions.size(), glm::dvec3(0)) {
    parallel_each(normals_.size(), 256, [&](std::size_t v) {
      const glm::dvec3 sum = by_angles(topology.corners_at(static_cast<std::int32_t>(v)));
      const double length = glm::length(sum);
      if (length > 0) normals_[v] = sum / length;
    });
  }

  // `sector`: corners at a vertex, counter-clockwise.
  [[nodiscard]] VertexJet fit(std::span<const std::int32_t> sector) const {
    const std::int32_t vertex = topology_.vertex_of(sector.front());
    VertexJet jet{};
    jet.origin = positions_[vertex];
    double size = 0;
    for (const std::int32_t corner : sector)
      size += glm::length(edge_to(topology_.next(corner), vertex)) +
              glm::length(edge_to(topology_.prev(corner), vertex));
    size /= 2 * static_cast<double>(sector.size());
    jet.normal = by_angles(sector);
    const double length = glm::length(jet.normal);
    jet.normal = length > 0 ? jet.normal / length : glm::dvec3(0, 0, 1);
    set_axes(jet);
    if (!(size > 0)) return jet;
    const std::vector<std::int32_t> ring = two_rings(sector, vertex);
    const glm::dvec3 by_angle = jet.normal;
    std::vector<Place> places = places_over(jet, ring, size);
    const double untilted = least_squares(places, kQuadrics, 2).left;
    for (int turn = 0; turn < kTurns; ++turn) {
      const Coefficients s = best_of(places, 0).coefficients;
      jet.normal = glm::normalize(jet.normal - s[0] * jet.e1 - s[1] * jet.e2);
      set_axes(jet);
      places = places_over(jet, ring, size);
    }
    const double tilted = best_of(places, 0).left;
    const double tilt = believed(tilted, untilted);
    jet.normal = glm::normalize(tilt * jet.normal + (1 - tilt) * by_angle);
    set_axes(jet);
    places = places_over(jet, ring, size);
    const LeastSquares fit = best_of(places, 2);
    const Coefficients& s = fit.coefficients;
    const double share = believed(fit.left, least_squares(places, kPlanes, 0).left);
    jet.doubt = 1 - share;
    for (int i = 0; i < 3; ++i) jet.quadric[i] = share * s[2 + i] / size;
    if (fit.is_implicit) {
      jet.implicit.emplace();
      for (int i = 0; i < 3; ++i) (*jet.implicit)[i] = share * s[5 + i] / size;
    } else {
      for (int i = 0; i < 4; ++i) jet.cubic[i] = share * s[5 + i] / (size * size);
    }
    return jet;
  }

 private:
  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  std::span<const char> is_sharp_;
  std::vector<glm::dvec3> normals_;  // by angles, of vertices, over all their faces

  [[nodiscard]] glm::dvec3 edge_to(std::int32_t corner, std::int32_t vertex) const {
    return positions_[topology_.vertex_of(corner)] - positions_[vertex];
  }

  // Sum of the faces' normals by their angles at the vertex.
  [[nodiscard]] glm::dvec3 by_angles(std::span<const std::int32_t> corners) const {
    glm::dvec3 sum(0);
    for (const std::int32_t corner : corners) {
      const std::int32_t vertex = topology_.vertex_of(corner);
      const glm::dvec3 a = edge_to(topology_.next(corner), vertex);
      const glm::dvec3 b = edge_to(topology_.prev(corner), vertex);
      const glm::dvec3 cross = glm::cross(a, b);
      const double length = glm::length(cross);
      if (length > 0) sum += cross / length * angle_between(a, b);
    }
    return sum;
  }

  [[nodiscard]] std::int32_t across(std::int32_t corner, bool ccw) const {
    const std::int32_t edge = topology_.edge_of(ccw ? topology_.prev(corner) : corner);
    if (is_sharp_[edge]) return -1;
    return ccw ? topology_.ccw(corner) : topology_.cw(corner);
  }

  void add_face(std::int32_t corner, std::int32_t vertex, std::vector<std::int32_t>& ring) const {
    for (const std::int32_t other : topology_.face(topology_.face_of(corner)))
      if (other != vertex) ring.push_back(other);
  }

  [[nodiscard]] std::vector<std::int32_t> two_rings(std::span<const std::int32_t> sector,
                                                    std::int32_t vertex) const {
    std::vector<std::int32_t> ring;
    for (const std::int32_t corner : sector) {
      add_face(corner, vertex, ring);
      for (const std::int32_t start : {topology_.next(corner), topology_.prev(corner)}) {
        for (const bool ccw : {false, true}) {
          std::int32_t at = across(start, ccw);
          for (int step = 0; at >= 0 && at != start && step < kWalk; ++step) {
            add_face(at, vertex, ring);
            at = across(at, ccw);
          }
        }
      }
    }
    std::ranges::sort(ring);
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
  }

  // A neighbour, over the jet's plane in units of the mean edge.
  struct Place {
    glm::dvec3 at;                 // over the jet's axes; z: its height
    Coefficients chord, implicit;  // what heights are sums of: see VertexJet
    double square;                 // of the weight
    glm::dvec3 facing;             // its normal by angles, over the jet's axes
  };
  // What heights are sums of; the first two coefficients tilt.
  struct Model {
    Coefficients Place::*row;
    int last;
  };
  static constexpr Model kPlanes{&Place::chord, 2}, kQuadrics{&Place::chord, kQuadric},
      kCubics{&Place::chord, kCubic}, kImplicits{&Place::implicit, kImplicit};

  [[nodiscard]] std::vector<Place> places_over(const VertexJet& jet,
                                               std::span<const std::int32_t> ring,
                                               double size) const {
    std::vector<Place> places;
    places.reserve(ring.size());
    for (const std::int32_t other : ring)
      places.push_back(place_of((positions_[other] - jet.origin) / size, normals_[other], jet));
    return places;
  }

  [[nodiscard]] static Place place_of(const glm::dvec3& to, const glm::dvec3& facing,
                                      const VertexJet& jet) {
    const auto over_axes = [&](const glm::dvec3& d) {
      return glm::dvec3(glm::dot(d, jet.e1), glm::dot(d, jet.e2), glm::dot(d, jet.normal));
    };
    const glm::dvec3 at = over_axes(to);
    const double flat = at.x * at.x + at.y * at.y, square = glm::dot(to, to);
    const double stretch = flat > 0 ? std::min(std::sqrt(square / flat), kMostStretched) : 1;
    const double x = stretch * at.x, y = stretch * at.y;
    const double weight = 1 / (1 + square);
    return {at,
            {at.x, at.y, x * x / 2, x * y, y * y / 2, x * x * x, x * x * y, x * y * y, y * y * y},
            {at.x, at.y, at.x * at.x / 2, at.x * at.y, at.y * at.y / 2, at.z * at.z / 2,
             at.x * at.z, at.y * at.z},
            weight * weight,
            over_axes(facing)};
  }

  struct LeastSquares {
    Coefficients coefficients{};
    double left = 0;  // what is left of each height by the fit to all others, squares
    bool is_implicit = false;
  };

  // Coefficients below `first` are 0.
  [[nodiscard]] static LeastSquares least_squares(std::span<const Place> places, const Model& model,
                                                  int first) {
    std::array<Coefficients, kCubic> matrix{};
    Coefficients right{};
    for (const Place& place : places) {
      const Coefficients& row = place.*model.row;
      for (int i = first; i < model.last; ++i) {
        for (int j = i; j < model.last; ++j) matrix[i][j] += place.square * row[i] * row[j];
        right[i] += place.square * row[i] * place.at.z;
      }
    }
    const Normal normal(matrix, first, model.last);
    LeastSquares fit{normal.solve(right), 0, model.row == &Place::implicit};
    // So few places are met by any heights.
    const bool is_open = std::ssize(places) <= model.last - first;
    for (const Place& place : places) {
      const Coefficients& row = place.*model.row;
      const double others = 1 - place.square * normal.leverage(row);
      double left = place.at.z;
      if (fit.is_implicit) {
        left = left_of_implicit(place, fit.coefficients, is_open ? 0 : others);
      } else if (!is_open) {
        double value = 0;
        for (int i = first; i < model.last; ++i) value += fit.coefficients[i] * row[i];
        left = (place.at.z - value) / std::max(others, kLeastOthers);
      }
      fit.left += place.square * left * left;
    }
    return fit;
  }

  // More than the height where the equation rises by less: a little of it is far on the surface.
  // Where others do not decide it tells nothing of a place, nor where it does not foretell how its
  // faces lie: such quadrics have other sides and sheets.
  [[nodiscard]] static double left_of_implicit(const Place& place, const Coefficients& coefficients,
                                               double others) {
    const Sum sum = sum_at(coefficients, true, place.at);
    const glm::dvec3 up = glm::dvec3(0, 0, 1) - sum.gradient;
    const double rise = glm::length(up), distance = glm::length(place.at);
    if (others <= kLeastOthers ||
        !(glm::dot(up, place.facing) > kLeastSmoothCosine * rise * glm::length(place.facing)))
      return distance;
    return std::min(std::abs(place.at.z - sum.value) / (others * std::min(rise, 1.0)), distance);
  }

  // What leaves least, the simpler one of two that leave as much.
  [[nodiscard]] static LeastSquares best_of(std::span<const Place> places, int first) {
    LeastSquares best = least_squares(places, kQuadrics, first);
    for (const Model& model : {kCubics, kImplicits}) {
      const LeastSquares other = least_squares(places, model, first);
      if (other.left < best.left) best = other;
    }
    return best;
  }

  // How far what leaves so much is believed against what leaves more.
  [[nodiscard]] static double believed(double left, double without) {
    return without > 0 ? std::clamp(1 - left / without, 0.0, 1.0) : 0.0;
  }
};

}  // namespace

glm::dvec3 VertexJet::on_jet(const glm::dvec3& place) const {
  const glm::dvec3 to = place - origin;
  const double px = glm::dot(to, e1), py = glm::dot(to, e2);
  const double flat = px * px + py * py, most = kSteepest * std::sqrt(flat);
  double z = 0;
  if (implicit) {
    // The root that is 0 at the vertex.
    const auto& [c, d, e] = *implicit;
    const double q = quadric[0] * px * px / 2 + quadric[1] * px * py + quadric[2] * py * py / 2;
    const double b = 1 - d * px - e * py;
    const double below = b + std::sqrt(std::max(b * b - 2 * c * q, 0.0));
    z = below > 0 ? std::clamp(2 * q / below, -most, most) : std::copysign(most, q);
    return place + (z - glm::dot(to, normal)) * normal;
  }
  for (int round = 0; round < kStretchRounds && flat > 0; ++round) {
    const double stretch = std::sqrt(1 + z * z / flat), x = stretch * px, y = stretch * py;
    z = quadric[0] * x * x / 2 + quadric[1] * x * y + quadric[2] * y * y / 2 +
        x * x * (cubic[0] * x + cubic[1] * y) + y * y * (cubic[2] * x + cubic[3] * y);
    z = std::clamp(z, -most, most);
  }
  return place + (z - glm::dot(to, normal)) * normal;
}

glm::dvec3 VertexJet::normal_at(const glm::dvec3& place) const {
  const glm::dvec3 to = place - origin;
  Coefficients all{0, 0, quadric[0], quadric[1], quadric[2]};
  if (implicit) {
    std::ranges::copy(*implicit, all.begin() + kQuadric);
  } else {
    std::ranges::copy(cubic, all.begin() + kQuadric);
  }
  const glm::dvec3 at(glm::dot(to, e1), glm::dot(to, e2), glm::dot(to, normal));
  const glm::dvec3 rise = sum_at(all, implicit.has_value(), at).gradient;
  const glm::dvec3 up = normal - rise.x * e1 - rise.y * e2 - rise.z * normal;
  const double length = glm::length(up);
  return length > 0 ? up / length : normal;
}

namespace {

// The jets of those vertices alone.
VertexJets fit_jets(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                    std::span<const char> is_sharp, std::span<const char> is_wanted) {
  VertexJets result;
  result.jet_of_corner.assign(topology.corner_count(), -1);
  // A sector starts behind a sharp edge; of a vertex without one anywhere.
  std::vector<std::int32_t> sector_begin{0}, sector_corners;
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    if (!is_wanted[v]) continue;
    const std::span<const std::int32_t> corners = topology.corners_at(v);
    const std::size_t count = corners.size();
    if (count == 0) continue;
    std::size_t first = 0;
    while (first < count && !is_sharp[topology.edge_of(corners[first])]) ++first;
    if (first == count) first = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t corner = corners[(first + i) % count];
      const bool starts = i > 0 && (is_sharp[topology.edge_of(corner)] || topology.cw(corner) < 0);
      if (starts) sector_begin.push_back(static_cast<std::int32_t>(sector_corners.size()));
      sector_corners.push_back(corner);
      result.jet_of_corner[corner] = static_cast<std::int32_t>(sector_begin.size()) - 1;
    }
    sector_begin.push_back(static_cast<std::int32_t>(sector_corners.size()));
  }
  const JetFitter fitter(positions, topology, is_sharp);
  result.jets.resize(sector_begin.size() - 1);
  parallel_each(result.jets.size(), 256, [&](std::size_t s) {
    const std::size_t begin = sector_begin[s];
    result.jets[s] =
        fitter.fit(std::span(sector_corners).subspan(begin, sector_begin[s + 1] - begin));
  });
  return result;
}

glm::dvec3 normal_of_face(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                          std::int32_t face) {
  const std::span<const std::int32_t> v = topology.face(face);
  const glm::dvec3& a = positions[v[0]];
  return glm::cross(positions[v[1]] - a, positions[v[2]] - a);
}

// Whether the jets of a face's corners leave little in doubt and foretell one another's normals.
bool are_told(const VertexJets& jets, const MeshTopology& topology, std::int32_t face) {
  const std::int32_t first = topology.first_corner(face);
  std::array<const VertexJet*, 3> own;
  for (int i = 0; i < 3; ++i) own[i] = &jets.jets[jets.jet_of_corner[first + i]];
  return std::ranges::all_of(own, [&](const VertexJet* jet) {
    return jet->doubt <= kToldDoubt && std::ranges::all_of(own, [&](const VertexJet* other) {
             return glm::dot(jet->normal_at(other->origin), other->normal) >= kToldCosine;
           });
  });
}

}  // namespace

VertexJets fit_vertex_jets(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                           std::span<const char> is_sharp) {
  return fit_jets(positions, topology, is_sharp, std::vector<char>(positions.size(), 1));
}

void mark_ridges(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                 std::span<char> is_sharp) {
  std::vector<char> is_ridge(is_sharp.size(), 0);
  parallel_each(is_ridge.size(), 1024, [&](std::size_t e) {
    const std::int32_t corner = topology.corner_of(static_cast<std::int32_t>(e));
    const std::int32_t twin = topology.twin(corner);
    if (twin < 0 || is_sharp[e]) return;
    const glm::dvec3 m = normal_of_face(positions, topology, topology.face_of(corner));
    const glm::dvec3 n = normal_of_face(positions, topology, topology.face_of(twin));
    is_ridge[e] = glm::dot(m, n) < kLeastSmoothCosine * glm::length(m) * glm::length(n);
  });
  std::vector<std::int32_t> ridges;
  std::vector<char> is_wanted(positions.size(), 0);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    if (!is_ridge[e]) continue;
    ridges.push_back(e);
    const std::int32_t corner = topology.corner_of(e);
    for (const std::int32_t side : {corner, topology.twin(corner)})
      for (const std::int32_t v : topology.face(topology.face_of(side))) is_wanted[v] = 1;
  }
  if (ridges.empty()) return;
  const VertexJets jets = fit_jets(positions, topology, is_sharp, is_wanted);
  for (const std::int32_t e : ridges) {
    const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
    if (!are_told(jets, topology, topology.face_of(corner)) ||
        !are_told(jets, topology, topology.face_of(twin)))
      is_sharp[e] = 1;
  }
}

namespace {

constexpr int kBlends = 2;
constexpr int kLooks = 4;             // parts of a face's edges
constexpr double kLeastRidge = 0.52;  // 30 degrees, between faces

}  // namespace

GuessSurface::GuessSurface(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                           std::span<const char> is_line, std::span<const char> is_sharp)
    : positions_(positions),
      topology_(topology),
      jets_(fit_vertex_jets(positions, topology, is_sharp)) {
  make_curves(is_line, is_sharp);
  is_flat_.assign(topology.face_count(), 0);
  std::vector<char> is_flat(topology.face_count());
  parallel_each(is_flat.size(), 64,
                [&](std::size_t f) { is_flat[f] = turns_too_far(static_cast<std::int32_t>(f)); });
  parallel_each(static_cast<std::size_t>(topology.edge_count()), 64, [&](std::size_t e) {
    const std::int32_t corner = topology.corner_of(static_cast<std::int32_t>(e));
    const std::int32_t twin = topology.twin(corner);
    if (twin < 0 || is_sharp[e] || !is_ridge(corner, twin)) return;
    for (const std::int32_t side : {corner, twin})
      if (!is_told(topology.face_of(side)))
        std::atomic_ref(is_flat[topology.face_of(side)]).store(1, std::memory_order_relaxed);
  });
  is_flat_ = std::move(is_flat);
}

bool GuessSurface::is_told(std::int32_t face) const { return are_told(jets_, topology_, face); }

// Whether the guess turns by more than faces may where two of them meet. Where these turn by little
// it may between slivers, which is no ridge.
bool GuessSurface::is_ridge(std::int32_t corner, std::int32_t twin) const {
  if (angle_between(face_normal(topology_.face_of(corner)), face_normal(topology_.face_of(twin))) <
      kLeastRidge)
    return false;
  const auto place = [&](std::int32_t side, double along, double inwards) {
    FacePlace made{topology_.face_of(side), glm::dvec3(0)};
    const int i = topology_.place_of(side);
    made.weights[i] = (1 - along) * (1 - inwards);
    made.weights[(i + 1) % 3] = along * (1 - inwards);
    made.weights[(i + 2) % 3] = inwards;
    return at(made);
  };
  for (int k = 0; k < kLooks; ++k) {
    const double begin = static_cast<double>(k) / kLooks, end = begin + 1.0 / kLooks;
    const double middle = (begin + end) / 2;
    const glm::dvec3 p = place(corner, begin, 0), q = place(corner, end, 0);
    const glm::dvec3 left = glm::cross(q - p, place(corner, middle, 1.0 / kLooks) - p);
    const glm::dvec3 right = glm::cross(place(twin, 1 - middle, 1.0 / kLooks) - p, q - p);
    if (!(glm::dot(left, right) >= kLeastSmoothCosine * glm::length(left) * glm::length(right)))
      return true;
  }
  return false;
}

bool GuessSurface::turns_too_far(std::int32_t face) const {
  if (is_told(face)) return false;
  std::array<glm::dvec3, (kLooks + 1) * (kLooks + 2) / 2> points;
  const auto number = [](int i, int j) { return (i + j) * (i + j + 1) / 2 + j; };
  for (int i = 0; i <= kLooks; ++i)
    for (int j = 0; i + j <= kLooks; ++j)
      points[number(i, j)] = at({face, glm::dvec3(kLooks - i - j, i, j) / double(kLooks)});
  const glm::dvec3 normal = face_normal(face);
  const auto turns = [&](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
    const glm::dvec3 part = glm::cross(q - p, r - p);
    return !(glm::dot(part, normal) >=
             kLeastSmoothCosine * glm::length(part) * glm::length(normal));
  };
  for (int i = 0; i < kLooks; ++i) {
    for (int j = 0; i + j < kLooks; ++j) {
      const glm::dvec3 &p = points[number(i, j)], &q = points[number(i + 1, j)],
                       &r = points[number(i, j + 1)];
      if (turns(p, q, r)) return true;
      if (i + j + 1 < kLooks && turns(q, points[number(i + 1, j + 1)], r)) return true;
    }
  }
  return false;
}

void GuessSurface::make_curves(std::span<const char> is_line, std::span<const char> is_sharp) {
  const std::int32_t edges = topology_.edge_count();
  const auto ends_surface = [&](std::int32_t edge) {
    return is_sharp[edge] || topology_.is_boundary_edge(edge);
  };
  // Others are only too sharp to be guessed, and stay straight.
  const auto is_curved = [&](std::int32_t edge) {
    return topology_.is_boundary_edge(edge) || (is_line[edge] && is_sharp[edge]);
  };
  // The one or two lines at a vertex, -1: none, -2: more than two.
  std::vector<std::array<std::int32_t, 2>> lines(topology_.vertex_count(), {-1, -1});
  for (std::int32_t e = 0; e < edges; ++e) {
    if (!is_curved(e)) continue;
    const auto [a, b] = topology_.edge_vertices(e);
    for (const std::int32_t v : {a, b}) {
      auto& two = lines[v];
      if (two[0] == -1) {
        two[0] = e;
      } else {
        two[1] = two[1] == -1 ? e : -2;
      }
    }
  }
  // Direction at a vertex from vertex `from` on: of the circle through three vertices of a line.
  const auto direction = [&](std::int32_t v, std::int32_t edge) {
    const auto [a, b] = topology_.edge_vertices(edge);
    const std::int32_t far = a == v ? b : a;
    const glm::dvec3 along = positions_[far] - positions_[v];
    const auto& two = lines[v];
    if (!is_curved(edge) || two[1] < 0) return along;
    const std::int32_t other = two[0] == edge ? two[1] : two[0];
    const auto [c, d] = topology_.edge_vertices(other);
    const glm::dvec3 back = positions_[v] - positions_[c == v ? d : c];
    const double l1 = glm::dot(along, along), l0 = glm::dot(back, back);
    if (!(l0 > 0) || !(l1 > 0) || glm::dot(along, back) < kLeastSmoothCosine * std::sqrt(l0 * l1))
      return along;
    const glm::dvec3 tangent = along / l1 + back / l0;
    return tangent * (std::sqrt(l1) / glm::length(tangent));
  };
  curve_of_corner_.assign(topology_.corner_count(), -1);
  for (std::int32_t e = 0; e < edges; ++e) {
    if (!ends_surface(e)) continue;
    const std::int32_t corner = topology_.corner_of(e), twin = topology_.twin(corner);
    const auto [a, b] = topology_.edge_vertices(e);
    const glm::dvec3 begin = direction(a, e), end = -direction(b, e);
    curve_of_corner_[corner] = static_cast<std::int32_t>(curves_.size());
    curves_.push_back({begin, end});
    if (twin < 0) continue;
    curve_of_corner_[twin] = static_cast<std::int32_t>(curves_.size());
    curves_.push_back({-end, -begin});
  }
}

glm::dvec3 GuessSurface::curve_point(std::int32_t corner, double t) const {
  const Curve& curve = curves_[curve_of_corner_[corner]];
  const glm::dvec3 p = positions_[topology_.vertex_of(corner)];
  const glm::dvec3 q = positions_[topology_.vertex_of(topology_.next(corner))];
  const double s = 1 - t;
  return s * s * (1 + 2 * t) * p + t * t * (1 + 2 * s) * q +
         s * t * (s * curve.begin - t * curve.end);
}

glm::dvec3 GuessSurface::face_normal(std::int32_t face) const {
  return normal_of_face(positions_, topology_, face);
}

glm::dvec3 GuessSurface::flat_point(const FacePlace& place) const {
  const std::span<const std::int32_t> v = topology_.face(place.face);
  return place.weights.x * positions_[v[0]] + place.weights.y * positions_[v[1]] +
         place.weights.z * positions_[v[2]];
}

glm::dvec3 GuessSurface::blend(const FacePlace& place) const {
  const std::int32_t first = topology_.first_corner(place.face);
  glm::dvec3 weights = place.weights * place.weights;
  weights /= weights.x + weights.y + weights.z;
  glm::dvec3 point = flat_point(place);
  for (int round = 0; round < kBlends; ++round) {
    glm::dvec3 sum(0);
    for (int i = 0; i < 3; ++i)
      if (weights[i] > 0)
        sum += weights[i] * jets_.jets[jets_.jet_of_corner[first + i]].on_jet(point);
    point = sum;
  }
  return point;
}

glm::dmat3 GuessSurface::turning(std::int32_t vertex) const {
  glm::dmat3 turning(0);
  double most = 0;
  for (const std::int32_t corner : topology_.corners_at(vertex)) {
    const VertexJet& jet = jets_.jets[jets_.jet_of_corner[corner]];
    const auto& [a, b, c] = jet.quadric;
    const double bending = a * a + 2 * b * b + c * c;
    if (!(bending > most)) continue;
    most = bending;
    // Where e1 and e2 turn the normal to.
    const glm::dvec3 u = a * jet.e1 + b * jet.e2, v = b * jet.e1 + c * jet.e2;
    turning = glm::outerProduct(u, u) + glm::outerProduct(v, v);
  }
  return turning;
}

glm::dvec3 GuessSurface::at(const FacePlace& place) const {
  const std::int32_t first = topology_.first_corner(place.face);
  if (is_flat_[place.face]) return flat_point(place);
  glm::dvec3 point = blend(place);
  for (int i = 0; i < 3; ++i) {
    if (curve_of_corner_[first + i] < 0) continue;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double along = place.weights[i] + place.weights[j];
    if (!(along > 0)) continue;
    const double share = place.weights[j] / along;
    FacePlace foot{place.face, glm::dvec3(0)};
    foot.weights[i] = 1 - share;
    foot.weights[j] = share;
    const double fade = (1 - place.weights[k]) * (1 - place.weights[k]);
    point += fade * (curve_point(first + i, share) - blend(foot));
  }
  return point;
}

namespace {

// Rings of few edges are uneven by chance: only what is narrower is narrow.
constexpr double kByChance = 1.5;
constexpr double kNarrowest = 4;
constexpr double kMostAcross = 0.25;

// A symmetric 2 x 2 matrix by its axes.
struct Axes {
  glm::dvec2 first, second;  // unit, at right angles
  double of_first, of_second;
};

Axes axes_of(double xx, double xy, double yy) {
  const double middle = (xx + yy) / 2, half = (xx - yy) / 2, reach = portable::hypot(half, xy);
  glm::dvec2 first(1, 0);
  if (reach > 0) {
    // The longer of two equal directions.
    first = half >= 0 ? glm::dvec2(half + reach, xy) : glm::dvec2(xy, reach - half);
    first = glm::normalize(first);
  }
  return {first, glm::dvec2(-first.y, first.x), middle + reach, middle - reach};
}

struct Ring {
  glm::dmat3 tensor{0.0};  // mean of e e^T over the edges
  glm::dvec3 normal{0.0};
  double length = 0;  // mean
};

std::vector<Ring> rings_of(std::span<const glm::dvec3> positions, const MeshTopology& topology) {
  std::vector<Ring> rings(positions.size());
  parallel_each(rings.size(), 256, [&](std::size_t v) {
    Ring& ring = rings[v];
    double count = 0;
    for (const std::int32_t corner : topology.corners_at(static_cast<std::int32_t>(v))) {
      const glm::dvec3 a = positions[topology.vertex_of(topology.next(corner))] - positions[v];
      const glm::dvec3 b = positions[topology.vertex_of(topology.prev(corner))] - positions[v];
      ring.normal += glm::cross(a, b);
      for (const glm::dvec3& edge : {a, b}) {
        ring.tensor += glm::outerProduct(edge, edge);
        ring.length += glm::length(edge);
        ++count;
      }
    }
    if (count == 0) return;
    ring.tensor /= count;
    ring.length /= count;
  });
  return rings;
}

}  // namespace

std::vector<glm::dmat3> spacing_metrics(std::span<const glm::dvec3> positions,
                                        const MeshTopology& topology, const GuessSurface& guess,
                                        const EvenTrianglesOptions& options) {
  const std::vector<Ring> rings = rings_of(positions, topology);
  std::vector<glm::dmat3> metrics(positions.size(), glm::dmat3(0));
  parallel_each(metrics.size(), 64, [&](std::size_t v) {
    const Ring& ring = rings[v];
    const auto vertex = static_cast<std::int32_t>(v);
    if (!(ring.length > 0)) return;
    // Single rings are uneven by chance.
    glm::dmat3 tensor = ring.tensor;
    double count = 1;
    for (const std::int32_t corner : topology.corners_at(vertex)) {
      const Ring& other = rings[topology.vertex_of(topology.next(corner))];
      const double length = other.length > 0 ? ring.length / other.length : 0;
      tensor += length * length * other.tensor;
      ++count;
    }
    tensor /= count;
    const double area = glm::length(ring.normal);
    const glm::dvec3 n = area > 0 ? ring.normal / area : glm::dvec3(0, 0, 1);
    const glm::dvec3 u = glm::normalize(
        glm::cross(n, std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 w = glm::cross(n, u);
    const auto in_plane = [&](const glm::dmat3& of, const glm::dvec3& a, const glm::dvec3& b) {
      return glm::dot(a, of * b);
    };
    const Axes shape =
        axes_of(in_plane(tensor, u, u), in_plane(tensor, u, w), in_plane(tensor, w, w));
    // Edges that leave the plane, as beside a spike, tell nothing of how triangles lie in it.
    const bool is_plane = glm::dot(n, tensor * n) < kMostAcross * shape.of_second;
    const double ratio = is_plane ? std::sqrt(shape.of_first / shape.of_second) : 1;
    const double narrow = std::sqrt(std::clamp(ratio / kByChance, 1.0, kNarrowest));
    // Of the mean edge's length as a whole, along and across: an area that stays.
    const double mean = ring.length * std::sqrt(2 / (narrow * narrow + 1 / (narrow * narrow)));
    // Ways of one mean edge.
    const glm::dvec3 along = mean * narrow * (shape.first.x * u + shape.first.y * w);
    const glm::dvec3 across = mean / narrow * (shape.second.x * u + shape.second.y * w);
    const glm::dmat3 turning = guess.turning(vertex);
    const double turn = glm::radians(options.turn);
    const Axes bend = axes_of(in_plane(turning, along, along), in_plane(turning, along, across),
                              in_plane(turning, across, across));
    // How many edges should take the place of a mean one.
    const auto parts = [&](double square) {
      return std::clamp(std::sqrt(std::max(square, 0.0)) / turn, 1 / options.spacing,
                        1 / options.least_spacing);
    };
    const glm::dvec3 dual_along = along / glm::dot(along, along),
                     dual_across = across / glm::dot(across, across);
    const auto direction = [&](const glm::dvec2& axis) {
      return axis.x * dual_along + axis.y * dual_across;
    };
    const double first = parts(bend.of_first);
    const double second = is_plane ? parts(bend.of_second) : first;
    const glm::dvec3 a = first * direction(bend.first), b = second * direction(bend.second);
    metrics[v] = glm::outerProduct(a, a) + glm::outerProduct(b, b);
    const double trace = metrics[v][0][0] + metrics[v][1][1] + metrics[v][2][2];
    metrics[v] += trace / 2 * glm::outerProduct(n, n);
  });
  return metrics;
}

}  // namespace planish
