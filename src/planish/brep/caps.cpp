#include "planish/brep/caps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/mesh/face_geometry.h"

namespace planish {

double CapBasis::limit_blossom(double t, const BlossomArguments& arguments) const {
  if (t >= 1) return 0;
  double product = 1;
  for (std::size_t a = 0; a < degree_; ++a) product *= 1 - arguments[a];
  return product;
}

double CapBasis::beside_blossom(double t, const BlossomArguments& arguments) const {
  if (t < 1) {
    constexpr std::array<double, kMostSplineDegree + 1> kPoints{0, 1, 0.5, 0.25};
    return bezier_blossom(kPoints.data(), degree_, arguments);
  }
  if (t >= 2) return 0;
  double product = last_;
  for (std::size_t a = 0; a < degree_; ++a) product *= 2 - arguments[a];
  return product;
}

void CapBasis::add_move(const CapMove& move, double x, double y, double size, PointNet& net) const {
  for (std::size_t j = 0; j <= degree_; ++j) {
    const BlossomArguments at_y = bezier_arguments(degree_, j, y, y + size);
    const double y0 = limit_blossom(y, at_y), y1 = beside_blossom(y, at_y);
    for (std::size_t i = 0; i <= degree_; ++i) {
      const BlossomArguments at_x = bezier_arguments(degree_, i, x, x + size);
      const double x0 = limit_blossom(x, at_x), x1 = beside_blossom(x, at_x);
      net[i + (degree_ + 1) * j] +=
          x1 * y0 * move.along_x + x0 * y1 * move.along_y + x1 * y1 * move.inside;
    }
  }
}

CornerPieces::CornerPieces(SplinePatch& patch, std::size_t degree, const std::array<int, 2>& depths)
    : degree_(degree) {
  std::vector<SplinePatch::End> ends;
  patch.add_pieces(depths, pieces_, ends);
  for (const SplinePatch::End& end : ends) add_cap(end, depths[end.is_face ? 1 : 0]);
}

void CornerPieces::add_cap(const SplinePatch::End& end, int depth) {
  // The end's place, the innermost square's far sides, and the polynomials across these.
  const double at = end.is_face ? 1 : 0, size = std::ldexp(1.0, -depth);
  const double inwards = end.is_face ? -size : size, far = at + inwards;
  const SquarePiece& beside_u = this->at(at + 1.5 * inwards, at + 0.5 * inwards);
  const SquarePiece& beside_v = this->at(at + 0.5 * inwards, at + 1.5 * inwards);
  SquarePiece cap;
  cap.u = cap.v = end.is_face ? 1 - size : 0;
  cap.size = size;
  cap.degree = degree_;
  for (std::size_t j = 0; j <= degree_; ++j) {
    for (std::size_t i = 0; i <= degree_; ++i) {
      const std::size_t k = i + (degree_ + 1) * j;
      cap.net[end.is_face ? cap.net_size() - 1 - k : k] =
          k == 0 ? end.limit
                 : (j > i ? beside_v : beside_u)
                       .blossom(bezier_arguments(degree_, i, at, far),
                                bezier_arguments(degree_, j, at, far));
    }
  }
  pieces_.push_back(cap);
}

void CornerPieces::move(const CapMove& move, bool is_face, int depth) {
  const double scale = std::ldexp(1.0, depth);
  const CapBasis basis(degree_);
  for (SquarePiece& piece : pieces_) {
    const double x = scale * (is_face ? 1 - piece.u - piece.size : piece.u);
    const double y = scale * (is_face ? 1 - piece.v - piece.size : piece.v);
    if (x >= 2 || y >= 2) continue;
    PointNet by{};
    basis.add_move(move, x, y, scale * piece.size, by);
    const std::size_t count = piece.net_size();
    for (std::size_t k = 0; k < count; ++k) piece.net[k] += by[is_face ? count - 1 - k : k];
  }
}

const SquarePiece& CornerPieces::at(double u, double v) const {
  for (const SquarePiece& piece : pieces_) {
    if (piece.holds(u, v)) return piece;
  }
  return pieces_.front();
}

namespace {

constexpr int kPlaces = 8;        // along the side of a square
constexpr int kAnglePlaces = 12;  // along an edge, for moves
constexpr int kRounds = 8;
constexpr double kLeastChange = 0.05;  // of a weight at once
constexpr std::size_t kOwnPlaces = 15;
constexpr double kDamping = 1e-12;  // where limits leave a move free
// Rings of the exact surface inside a square; what is left within them differs by less, since
// differences fall from ring to ring.
constexpr int kRings = 3;

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
  std::array<glm::dvec3, kMostSplineDegree + 1> line, along, side;
  for (std::size_t k = 0; k <= degree; ++k) {
    line[k] = net[k * step];
    side[k] = net[k * step + across] - net[k * step];
    if (k < degree) along[k] = net[(k + 1) * step] - net[k * step];
  }
  return {bezier_blossom(line.data(), degree, part), bezier_blossom(along.data(), degree - 1, part),
          bezier_blossom(side.data(), degree, part)};
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

CapError CapMeasure::of(std::span<const std::int32_t> corners, bool is_face, int depth,
                        const CapLimits& limits, bool is_final) {
  corners_.assign(corners.begin(), corners.end());
  is_face_ = is_face;
  depth_ = depth;
  caps_.assign(corners.size(), {});
  places_.resize(corners.size());
  checks_.clear();
  CapError error;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::int32_t c = corners[i];
    places_[i].clear();
    if (layout_.is_hidden(c)) continue;
    const CornerPieces pieces = written_pieces(c);
    const double size = std::ldexp(1.0, -depth);
    // Of the square [x, x + 1] x [y, y + 1] from the point alone: where one side is regular its
    // piece is larger than the square, and the other's may not be.
    const auto net = [&](double x, double y) {
      const auto from = [&](double t) { return is_face ? 1 - size * t : size * t; };
      const SquarePiece& piece = pieces.at(from(x + 0.5), from(y + 0.5));
      return piece.part(from(x), from(x + 1), from(y), from(y + 1));
    };
    caps_[i] = {surface_.degree(), net(0, 0), net(1, 0), net(0, 1)};
    point_ = caps_[i].inside.front();
    add_places(c, depth, pieces, places_[i]);
    for (std::size_t k = 0; k < kOwnPlaces; ++k)
      error.add_deviation(off_surface(places_[i][k].apart, places_[i][k].normal), {});
  }
  error.add_angle(sampled_angle(1), {});
  return is_final || error.part_of(limits) <= 1 ? bound({}, limits, is_final) : error;
}

// A corner's polynomials with the depths that are measured, and the moves at its face's centre. Of
// a face without the square at the vertex, which is chosen later and measured then.
CornerPieces CapMeasure::written_pieces(std::int32_t corner) {
  patch_->move_to(corner);
  const std::int32_t face = layout_.origin(4 * corner + 2);
  CornerPieces pieces(
      *patch_, surface_.degree(),
      {is_face_ ? depth_ + kRings : depth_, is_face_ ? depth_ : depths_.of_vertex[face]});
  const std::int32_t across = is_face_ ? -1 : depths_.of_corner[corner][1];
  if (across >= 0) pieces.move(depths_.moves[across], true, depths_.of_vertex[face]);
  return pieces;
}

// Squares of the exact surface, as far as moves reach.
void CapMeasure::add_checks(std::int32_t corner, std::vector<Check>& checks) {
  const CornerPieces written = written_pieces(corner);
  const std::int32_t face = layout_.origin(4 * corner + 2);
  std::vector<SquarePiece> exact;
  std::vector<SplinePatch::End> ends;
  patch_->add_pieces({depth_ + kRings, (is_face_ ? depth_ : depths_.of_vertex[face]) + kRings},
                     exact, ends);
  const double scale = std::ldexp(1.0, depth_);
  for (const SquarePiece& piece : exact) {
    const double x = scale * (is_face_ ? 1 - piece.u - piece.size : piece.u);
    const double y = scale * (is_face_ ? 1 - piece.v - piece.size : piece.v);
    if (x >= 2 || y >= 2) continue;
    const double u = piece.u + 0.5 * piece.size, v = piece.v + 0.5 * piece.size;
    const SquarePiece& there = written.at(u, v);
    Check check{
        x,
        y,
        scale * piece.size,
        {there.blossom(same_arguments(u), same_arguments(v)), surface_.topology().face_of(corner)},
        PieceBound(piece),
        {}};
    check.apart = there.part(piece.u, piece.u + piece.size, piece.v, piece.v + piece.size);
    for (std::size_t k = 0; k < piece.net_size(); ++k) check.apart[k] -= piece.net[k];
    checks.push_back(check);
  }
}

CapError CapMeasure::bound(std::span<const CapMove> moves, const CapLimits& limits, bool is_final) {
  if (checks_.empty()) {
    checks_.resize(corners_.size());
    for (std::size_t i = 0; i < corners_.size(); ++i)
      if (!layout_.is_hidden(corners_[i])) add_checks(corners_[i], checks_[i]);
  }
  CapError error;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    for (const Check& check : checks_[i]) {
      PointNet apart = check.apart;
      if (!moves.empty()) {
        PointNet by{};
        basis_.add_move(moves[i], check.x, check.y, check.size, by);
        const std::size_t count = (surface_.degree() + 1) * (surface_.degree() + 1);
        for (std::size_t k = 0; k < count; ++k) apart[k] += by[is_face_ ? count - 1 - k : k];
      }
      error.add_deviation(check.exact.distance(apart, error.deviation), check.middle);
      if (!is_final && error.part_of(limits) > 1) return error;
    }
  }
  for_edges([&](const Cap& cap, const Cap& other, std::int32_t corner) {
    Jump jump;
    for (const bool is_beside : {true, false}) {
      if (is_beside && moves.empty()) continue;  // goes on as it is
      add_jump(sides(cap, other, is_beside), point_, jump);
    }
    error.add_angle(jump.angle * 180 / std::numbers::pi,
                    {jump.position, surface_.topology().face_of(corner)});
  });
  return error;
}

MeetingSides CapMeasure::sides(const Cap& cap, const Cap& other, bool is_beside) {
  const std::size_t row = cap.degree + 1;
  const PointNet& left = is_beside ? cap.beside_y : cap.inside;
  const PointNet& right = is_beside ? other.beside_x : other.inside;
  MeetingSides sides;
  sides.degree = cap.degree;
  for (std::size_t k = 0; k < row; ++k) {
    sides.line[k] = left[row * k];
    sides.left[k] = left[row * k + 1] - left[row * k];
    sides.right[k] = right[k + row] - right[k];
  }
  return sides;
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

// Of each edge that corners' squares share with the next ones', from the point on.
template <class Use>
void CapMeasure::for_edges(const Use& use) const {
  const MeshTopology& topology = surface_.topology();
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const std::int32_t c = corners_[i];
    if (layout_.is_hidden(c)) continue;
    const std::int32_t next = is_face_ ? topology.next(c) : topology.ccw(c);
    if (next < 0 || layout_.is_hidden(next)) continue;
    if (!is_face_ && layout_.is_sharp(4 * c + 3)) continue;
    use(caps_[i], caps_[(i + 1) % corners_.size()], c);
  }
}

// Where normals are told by more than rounding.
double CapMeasure::sampled_angle(double until) const {
  double largest = 0;
  for_edges([&](const Cap& cap, const Cap& other, std::int32_t) {
    for (int k = 1; k <= kPlaces * until; ++k) {
      const double t = double(k) / kPlaces;
      const Cap::Border a = cap.border(true, t), b = other.border(false, t);
      if (glm::length(a.line - point_) <= Brep::kSamePlace) continue;
      const glm::dvec3 left = glm::cross(a.side, a.along), right = glm::cross(b.along, b.side);
      largest = std::max(largest, angle_between(left, right) - a.turned_by_rounding(left) -
                                      b.turned_by_rounding(right));
    }
  });
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

bool CapMeasure::move(const CapLimits& limits, bool is_final, CapError& moved) {
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
    if (is_final || error.part_of(limits) <= 1) error = bound(moves_, limits, is_final);
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
  error.add_angle(sampled_angle(2), {});
  for (std::size_t i = 0; i < places_.size(); ++i)
    for (const Place& place : places_[i])
      error.add_deviation(
          off_surface(place.apart + basis_.moved_by(moves_[i], place.x, place.y), place.normal),
          {});
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
      if (!(a.turned_by_rounding(left) + b.turned_by_rounding(other) < angle_limit)) continue;
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

namespace {

// What was chosen for a place.
struct Choice {
  int depth = 1;
  CapError error;
  std::vector<CapMove> moves;
};

Choice choose(CapMeasure& measure, std::span<const std::int32_t> corners, bool is_face,
              const CapLimits& limits) {
  // Moves bring no more.
  constexpr double kMostPart = 16;
  Choice choice;
  for (int depth = 1;; ++depth) {
    choice.depth = depth;
    const bool is_final = depth == kDeepestCap;
    choice.error = measure.of(corners, is_face, depth, limits, is_final);
    const double part = choice.error.part_of(limits);
    if (part <= 1) return choice;
    CapError moved;
    if ((part <= kMostPart || is_final) && measure.move(limits, is_final, moved)) {
      const double moved_part = moved.part_of(limits);
      if (moved_part <= 1 || (is_final && moved_part < part)) {
        choice.error = moved;
        choice.moves.assign(measure.moves().begin(), measure.moves().end());
        return choice;
      }
    }
    if (is_final) return choice;
  }
}

}  // namespace

CapDepths cap_depths(const SplineSurface& surface, const QuadLayout& layout,
                     const CapLimits& limits, const Callbacks& callbacks) {
  const MeshTopology& topology = surface.topology();
  const std::int32_t first_face = topology.vertex_count() + topology.edge_count();
  // Faces first, which vertices' choices take for given.
  std::vector<std::int32_t> places;
  for (std::int32_t v = 0; v < layout.vertex_count(); ++v) {
    if (layout.is_extraordinary(v) &&
        !(v >= first_face && layout.is_hidden(topology.first_corner(v - first_face))))
      places.push_back(v);
  }
  std::ranges::stable_partition(places, [&](std::int32_t v) { return v >= first_face; });
  const auto face_count = static_cast<std::size_t>(
      std::ranges::count_if(places, [&](std::int32_t v) { return v >= first_face; }));
  CapDepths depths;
  depths.of_vertex.assign(static_cast<std::size_t>(layout.vertex_count()), 1);
  depths.of_corner.assign(static_cast<std::size_t>(topology.corner_count()), {-1, -1});
  depths.count = static_cast<std::int64_t>(places.size());
  std::vector<Choice> choices(places.size());
  LoopProgress progress(callbacks, "faces", 0, 1, std::ssize(places));

  const auto corners_of = [&](std::int32_t place, std::vector<std::int32_t>& around) {
    around.clear();
    if (place >= first_face) {
      const std::int32_t face = place - first_face;
      for (std::int32_t k = 0; k < topology.face_size(face); ++k)
        around.push_back(topology.first_corner(face) + k);
    } else {
      const auto corners = topology.corners_at(place);
      around.assign(corners.begin(), corners.end());
    }
  };
  const auto choose_all = [&](std::size_t first, std::size_t count) {
    parallel_for(count, 16, [&](std::size_t begin, std::size_t end) {
      CapMeasure measure(surface, layout, depths);
      std::vector<std::int32_t> around;
      for (std::size_t i = first + begin; i < first + end; ++i) {
        corners_of(places[i], around);
        choices[i] = choose(measure, around, places[i] >= first_face, limits);
        progress.add();
      }
    });
    std::vector<std::int32_t> around;
    for (std::size_t i = first; i < first + count; ++i) {
      const Choice& choice = choices[i];
      depths.worst.add(choice.error);
      depths.of_vertex[places[i]] = static_cast<std::int8_t>(choice.depth);
      depths.deepest = std::max(depths.deepest, choice.depth);
      if (choice.moves.empty()) continue;
      ++depths.moved;
      corners_of(places[i], around);
      for (std::size_t k = 0; k < around.size(); ++k) {
        depths.of_corner[around[k]][places[i] >= first_face ? 1 : 0] =
            static_cast<std::int32_t>(depths.moves.size());
        depths.moves.push_back(choice.moves[k]);
      }
    }
  };
  choose_all(0, face_count);
  choose_all(face_count, places.size() - face_count);
  return depths;
}

}  // namespace planish
