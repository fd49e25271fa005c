#include "planish/brep/cap_measure.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/mesh/angle_between.h"

namespace planish {
namespace {

constexpr int kFinePlaces = 32;
constexpr int kPlaces = 8;        // along the side of a square
constexpr int kAnglePlaces = 12;  // along an edge, for moves
constexpr int kRounds = 8;
constexpr double kLeastChange = 0.05;  // of a weight at once
constexpr std::size_t kOwnPlaces = 15;
constexpr double kDamping = 1e-12;  // where limits leave a move free

// How a residual follows an unknown.
struct Change {
  std::size_t unknown = 0;
  double by = 0;
};

double off_surface(const glm::dvec3& apart, const glm::dvec3& normal) {
  return normal == glm::dvec3(0.0) ? glm::length(apart) : std::abs(glm::dot(apart, normal));
}

// Cholesky's scheme; (i, j) of the lower half at i + n j.
void solve_positive(std::span<double> matrix, std::span<double> right) {
  const std::size_t n = right.size();
  for (std::size_t j = 0; j < n; ++j) {
    const double root = std::sqrt(matrix[j + n * j]);
    for (std::size_t i = j; i < n; ++i) matrix[i + n * j] /= root;
    for (std::size_t k = j + 1; k < n; ++k)
      for (std::size_t i = k; i < n; ++i)
        matrix[i + n * k] -= matrix[i + n * j] * matrix[k + n * j];
    right[j] /= matrix[j + n * j];
    for (std::size_t i = j + 1; i < n; ++i) right[i] -= matrix[i + n * j] * right[j];
  }
  for (std::size_t j = n; j-- > 0;) {
    for (std::size_t i = j + 1; i < n; ++i) right[j] -= matrix[i + n * j] * right[i];
    right[j] /= matrix[j + n * j];
  }
}

}  // namespace

CapMeasure::Cap::Border CapMeasure::Cap::border(bool along_y, double t) const {
  const std::size_t step = along_y ? degree + 1 : 1, across = along_y ? 1 : degree + 1;
  const PointNet& net = t <= 1 ? inside : along_y ? beside_y : beside_x;
  const BlossomArguments part = same_arguments(t <= 1 ? t : t - 1);
  std::array<glm::dvec3, kMostSplineDegree + 1> along, side;
  for (std::size_t k = 0; k <= degree; ++k) {
    side[k] = net[k * step + across] - net[k * step];
    if (k < degree) along[k] = net[(k + 1) * step] - net[k * step];
  }
  return {bezier_blossom(along.data(), degree - 1, part),
          bezier_blossom(side.data(), degree, part)};
}

glm::dvec3 CapMeasure::Cap::normal(bool along_y, double t) const {
  const Border b = border(along_y, t);
  return along_y ? glm::cross(b.side, b.along) : glm::cross(b.along, b.side);
}

void CapMeasure::Cap::add(const CapBasis& basis, const CapMove& move) {
  basis.add_move(move, 0, 0, 1, inside);
  basis.add_move(move, 1, 0, 1, beside_x);
  basis.add_move(move, 0, 1, 1, beside_y);
}

CornerPieces pieces_of(SplinePatch& patch, std::int32_t corner, const QuadLayout& layout,
                       const CapDepths& depths) {
  const std::array<std::int32_t, 2> vertices{layout.origin(4 * corner),
                                             layout.origin(4 * corner + 2)};
  std::array<int, 2> depth{};
  for (const std::size_t end : {0u, 1u}) depth[end] = depths.of_vertex[vertices[end]];
  CornerPieces pieces(patch, layout.degree(), depth);
  for (const std::size_t end : {0u, 1u}) {
    const std::int32_t move = depths.of_corner[corner][end];
    if (move >= 0) pieces.move(depths.moves[move], end == 1, depth[end]);
  }
  return pieces;
}

CapError CapMeasure::of(std::span<const std::int32_t> corners, bool is_face, int depth) {
  corners_.assign(corners.begin(), corners.end());
  is_face_ = is_face;
  caps_.assign(corners.size(), {});
  places_.resize(corners.size());
  CapError error;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::int32_t c = corners[i];
    places_[i].clear();
    if (layout_.is_hidden(c)) continue;
    patch_->move_to(c);
    const std::int32_t face = layout_.origin(4 * c + 2);
    CornerPieces pieces(*patch_, surface_.degree(),
                        {depth, is_face ? depth : depths_.of_vertex[face]});
    const std::int32_t across = is_face ? -1 : depths_.of_corner[c][1];
    if (across >= 0) pieces.move(depths_.moves[across], true, depths_.of_vertex[face]);
    const double size = std::ldexp(1.0, -depth);
    const auto net = [&](double x, double y) {
      const SquarePiece& piece =
          is_face ? pieces.at(1 - size * x, 1 - size * y) : pieces.at(size * x, size * y);
      PointNet turned;
      const std::size_t count = piece.net_size();
      for (std::size_t k = 0; k < count; ++k) turned[k] = piece.net[is_face ? count - 1 - k : k];
      return turned;
    };
    caps_[i] = {surface_.degree(), net(0.5, 0.5), net(1.5, 0.5), net(0.5, 1.5)};
    add_places(c, depth, pieces, places_[i]);
    for (std::size_t k = 0; k < kOwnPlaces; ++k)
      error.deviation =
          std::max(error.deviation, off_surface(places_[i][k].apart, places_[i][k].normal));
  }
  error.angle = angle(1, kFinePlaces / 2);
  return error;
}

// In the corner's own square, in those that moves change and, where these reach into the square at
// the face's centre, in that.
void CapMeasure::add_places(std::int32_t corner, int depth, const CornerPieces& pieces,
                            std::vector<Place>& places) {
  const double size = std::ldexp(1.0, -depth), end = is_face_ ? 1 - 0.5 * size : 0.5 * size;
  add_square(pieces.at(end, end), is_face_, depth, places);
  const auto at_face = static_cast<std::size_t>(layout_.origin(4 * corner + 2));
  const int depth_at_face = depths_.of_vertex[at_face];
  if (!is_face_ && depth == 1 && layout_.is_extraordinary(static_cast<std::int32_t>(at_face))) {
    const double middle = 1 - std::ldexp(0.5, -depth_at_face);
    add_square(pieces.at(middle, middle), true, depth, places);
  }
  const std::int32_t across = is_face_ ? -1 : depths_.of_corner[corner][1];
  const double scale = std::ldexp(1.0, depth_at_face);
  for (int j = 0; j < 8; ++j) {
    for (int k = 0; k < 8; ++k) {
      if (j < 4 && k < 4) continue;
      Place place{0.25 * k, 0.25 * j, {}, {}};
      const double x = scale * (1 - size * place.x), y = scale * (1 - size * place.y);
      if (across >= 0 && x < 2 && y < 2) place.apart = basis_.moved_by(depths_.moves[across], x, y);
      places.push_back(place);
    }
  }
}

// Its borders at the point are among the places, those across, where it goes on as it is, are not.
void CapMeasure::add_square(const SquarePiece& piece, bool is_at_face, int depth,
                            std::vector<Place>& places) {
  const double scale = std::ldexp(1.0, depth);
  for (int j = 0; j < 4; ++j) {
    for (int k = j == 0 ? 1 : 0; k < 4; ++k) {
      const double u = piece.u + 0.25 * (is_at_face ? 4 - k : k) * piece.size;
      const double v = piece.v + 0.25 * (is_at_face ? 4 - j : j) * piece.size;
      const SplinePatch::Point exact = patch_->at(u, v);
      const double length = glm::length(exact.normal);
      places.push_back({scale * (is_face_ ? 1 - u : u), scale * (is_face_ ? 1 - v : v),
                        piece.blossom(same_arguments(u), same_arguments(v)) - exact.position,
                        length > 0 ? exact.normal / length : glm::dvec3(0.0)});
    }
  }
}

// Across the edges that corners' squares share with the next ones', from the point on.
double CapMeasure::angle(double until, int places) const {
  const MeshTopology& topology = surface_.topology();
  double largest = 0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const std::int32_t c = corners_[i];
    if (layout_.is_hidden(c)) continue;
    const std::int32_t next = is_face_ ? topology.next(c) : topology.ccw(c);
    if (next < 0 || layout_.is_hidden(next)) continue;
    if (!is_face_ && layout_.is_sharp(4 * c + 3)) continue;
    const Cap& other = caps_[(i + 1) % corners_.size()];
    for (int k = 0; k <= places * until; ++k) {
      const double t = double(k) / places;
      largest = std::max(largest, angle_between(caps_[i].normal(true, t), other.normal(false, t)));
    }
  }
  return largest * 180 / std::numbers::pi;
}

bool CapMeasure::can_move() const {
  if (corners_.size() < 3 || corners_.size() > kMostMovedCorners) return false;
  const MeshTopology& topology = surface_.topology();
  return std::ranges::all_of(corners_, [&](std::int32_t c) {
    if (layout_.is_hidden(c)) return false;
    return is_face_ || (topology.ccw(c) >= 0 && !layout_.is_hidden(topology.ccw(c)) &&
                        !layout_.is_sharp(4 * c + 3));
  });
}

bool CapMeasure::move(const CapLimits& limits, CapError& moved) {
  if (!can_move()) return false;
  patch_->move_to(corners_.front());
  const double end = is_face_ ? 1 : 0;
  const glm::dvec3 across = patch_->at(end, end).normal;
  const double length = glm::length(across);
  if (!(length > 0)) return false;
  moves_.assign(corners_.size(), {});
  weights_.clear();
  std::vector<CapMove> best;
  for (int round = 0; round < kRounds; ++round) {
    improve_moves(across / length, limits, moved.part_of(limits));
    CapError error = moved_error();
    // Parts that are made alike are largest between places.
    if (error.part_of(limits) <= 1) error.angle = angle(2, kFinePlaces);
    if (round == 0 || error.part_of(limits) < moved.part_of(limits)) {
      moved = error;
      best = moves_;
    }
    if (moved.part_of(limits) <= 1) break;
  }
  moves_ = std::move(best);
  return true;
}

CapError CapMeasure::moved_error() const {
  CapError error;
  error.angle = angle(2, kPlaces);
  for (std::size_t i = 0; i < places_.size(); ++i)
    for (const Place& place : places_[i])
      error.deviation = std::max(
          error.deviation,
          off_surface(place.apart + basis_.moved_by(moves_[i], place.x, place.y), place.normal));
  return error;
}

// A step of Gauss and Newton for the normals' cross products along the edges and the deviations,
// each as a part of its limit, and weighted more where it was large (Lawson): towards the least
// largest part. Unknowns are the moves along the normal: of the n points inside, then of the n on
// borders, that of border i between corners i and i + 1.
void CapMeasure::improve_moves(const glm::dvec3& normal, const CapLimits& limits,
                               double largest_part) {
  const std::size_t n = corners_.size(), count = 2 * n;
  const double angle_limit = limits.angle * std::numbers::pi / 180;
  std::vector<double> matrix(count * count), right(count);
  const bool is_first = weights_.empty();
  std::size_t residuals = 0;
  const auto add = [&](double residual, std::span<const Change> changes) {
    if (is_first) {
      weights_.push_back(1);
    } else {
      weights_[residuals] *= std::clamp(std::abs(residual) / largest_part, kLeastChange, 1.0);
    }
    const double weight = weights_[residuals++];
    for (const Change& a : changes) {
      for (const Change& b : changes)
        if (a.unknown >= b.unknown) matrix[a.unknown + count * b.unknown] += weight * a.by * b.by;
      right[a.unknown] -= weight * a.by * residual;
    }
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n, before = (i + n - 1) % n;
    for (int k = 0; k < kAnglePlaces; ++k) {
      const double t = 2.0 * k / kAnglePlaces;
      const Cap::Border a = caps_[i].border(true, t), b = caps_[next].border(false, t);
      const glm::dvec3 left = glm::cross(a.side, a.along), other = glm::cross(b.along, b.side);
      const double scale =
          glm::length(left) * glm::length(other) * glm::length(a.along) * angle_limit;
      if (!(scale > 0)) continue;
      const glm::dvec3 left_side = glm::cross(normal, a.along),
                       other_side = glm::cross(b.along, normal);
      const auto change = [&](std::size_t unknown, const glm::dvec3& of_left,
                              const glm::dvec3& of_other) {
        return Change{
            unknown,
            glm::dot(glm::cross(of_left, other) + glm::cross(left, of_other), a.along) / scale};
      };
      constexpr glm::dvec3 kNone(0.0);
      const double on = basis_.beside(t), at_point = basis_.limit(t),
                   slope = basis_.beside_slope(t);
      add(glm::dot(glm::cross(left, other), a.along) / scale,
          std::array{change(i, on * left_side, kNone), change(next, kNone, on * other_side),
                     change(n + i, slope * glm::cross(a.side, normal) - on * left_side,
                            slope * glm::cross(normal, b.side) - on * other_side),
                     change(n + before, at_point * left_side, kNone),
                     change(n + next, kNone, at_point * other_side)});
    }
    for (const Place& place : places_[i]) {
      const glm::dvec3& across = place.normal == glm::dvec3(0.0) ? normal : place.normal;
      const double off =
          glm::dot(place.apart + basis_.moved_by(moves_[i], place.x, place.y), across);
      const double part = glm::dot(normal, across) / limits.deviation;
      const double x1 = basis_.beside(place.x), y1 = basis_.beside(place.y);
      add(off / limits.deviation,
          std::array{Change{i, part * x1 * y1}, Change{n + i, part * basis_.limit(place.x) * y1},
                     Change{n + before, part * x1 * basis_.limit(place.y)}});
    }
  }
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, matrix[i + count * i]);
  if (!(largest > 0)) return;
  for (std::size_t i = 0; i < count; ++i) matrix[i + count * i] += kDamping * largest;
  solve_positive(matrix, right);
  for (std::size_t i = 0; i < n; ++i) {
    const CapMove step{right[n + (i + n - 1) % n] * normal, right[n + i] * normal,
                       right[i] * normal};
    caps_[i].add(basis_, step);
    moves_[i].along_x += step.along_x;
    moves_[i].along_y += step.along_y;
    moves_[i].inside += step.inside;
  }
}

}  // namespace planish
