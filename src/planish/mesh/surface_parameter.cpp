#include "planish/mesh/surface_parameter.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "planish/core/error.h"
#include "planish/core/number_text.h"

namespace planish {
namespace {

constexpr double kJustOutside = 1e-9;

// Tiles in a row.
std::int32_t tiles_across(std::int32_t m) {
  if (m < 10) return m > 4 ? 3 : 2;
  return 1 + static_cast<std::int32_t>(std::sqrt(static_cast<double>(m - 1)));
}

[[noreturn]] void refuse(const SurfaceParameter& at, const std::string& what) {
  throw Error(ErrorCode::InvalidArgument,
              formatted("face {} at ({}, {}): {}", at.face, shortest(at.u), shortest(at.v), what));
}

double inside(double value, double largest, const SurfaceParameter& at) {
  if (!(value >= -kJustOutside && value <= largest + kJustOutside))
    refuse(at, "lies outside the face");
  return std::clamp(value, 0.0, largest);
}

// The tile's place along one direction, and what is left. What lies just before a tile is its own.
std::pair<std::int32_t, double> tile_of(double value, const SurfaceParameter& at) {
  if (!(value > -1 && value < 1e6)) refuse(at, "lies outside the face");
  auto tile = static_cast<std::int32_t>(std::floor(value));
  double rest = value - tile;
  if (rest > 0.75) ++tile, rest -= 1;
  return {tile, inside(rest, 0.5, at)};
}

}  // namespace

CornerParameter corner_parameter(const MeshTopology& topology, const SurfaceParameter& at) {
  if (at.face < 0 || at.face >= topology.face_count())
    refuse(at, formatted("the mesh has {} faces", topology.face_count()));
  const std::int32_t first = topology.first_corner(at.face);
  const std::int32_t m = topology.face_size(at.face);
  if (m != 4) {
    const auto [i, u] = tile_of(at.u, at);
    const auto [j, v] = tile_of(at.v, at);
    const std::int32_t across = tiles_across(m);
    if (i < 0 || i >= across || j < 0 || j * across + i >= m) refuse(at, "lies outside the face");
    return {first + j * across + i, 2 * u, 2 * v, 1, 0};
  }
  const double u = inside(at.u, 1, at), v = inside(at.v, 1, at);
  if (v < 0.5) {
    if (u < 0.5) return {first, 2 * u, 2 * v, 1, 0};
    return {first + 1, 2 * v, 2 - 2 * u, 0, 1};
  }
  if (u < 0.5) return {first + 3, 2 - 2 * v, 2 * u, 0, -1};
  return {first + 2, 2 - 2 * u, 2 - 2 * v, -1, 0};
}

SurfaceParameter surface_parameter(const MeshTopology& topology, std::int32_t corner, double u,
                                   double v) {
  const std::int32_t face = topology.face_of(corner), place = topology.place_of(corner);
  const std::int32_t m = topology.face_size(face);
  if (m != 4) {
    const std::int32_t across = tiles_across(m);
    const std::int32_t row = place / across, column = place % across;
    return {face, column + u / 2, row + v / 2};
  }
  switch (place) {
    case 0:
      return {face, u / 2, v / 2};
    case 1:
      return {face, 1 - v / 2, u / 2};
    case 2:
      return {face, 1 - u / 2, 1 - v / 2};
    default:
      return {face, v / 2, 1 - u / 2};
  }
}

}  // namespace planish
