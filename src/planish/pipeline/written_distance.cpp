#include "planish/pipeline/written_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/safe_length.h"

namespace planish {
namespace {

// Of points that come as pairs, apart(i) of [0, count); infinite where one is not a number.
template <class Apart>
double largest_of(std::size_t count, const Apart& apart) {
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    largest = std::max(largest, safe_length(apart(i)));
    if (std::isinf(largest)) break;
  }
  return largest;
}

// The same on all threads: of_piece(range) of the ranges of [0, count).
template <class OfPiece>
double largest_of_pieces(std::int64_t count, const OfPiece& of_piece) {
  constexpr std::int64_t kPiece = 1 << 14;
  const std::vector<RowRange> pieces = ranges_of(count, kPiece);
  std::vector<double> largest(pieces.size(), 0);
  parallel_each(pieces.size(), 1, [&](std::size_t i) { largest[i] = of_piece(pieces[i]); });
  return largest.empty() ? 0 : *std::max_element(largest.begin(), largest.end());
}

}  // namespace

double largest_distance(const SurfaceInfo& info, std::span<const glm::dvec3> given,
                        const RowPositions& positions) {
  const auto count = std::min(static_cast<std::int64_t>(info.base_vertices.size()), info.row_count);
  return largest_of_pieces(count, [&](RowRange rows) {
    thread_local std::vector<glm::dvec3> some;
    some.resize(static_cast<std::size_t>(rows.count));
    positions(rows, some);
    const std::int32_t* vertices = info.base_vertices.data() + rows.first;
    return largest_of(some.size(), [&](std::size_t i) { return some[i] - given[vertices[i]]; });
  });
}

double written_distance(const SurfaceBlocks& surface, std::span<const glm::dvec3> given,
                        FileFormat format) {
  return largest_distance(surface.info(), given, [&](RowRange rows, std::span<glm::dvec3> some) {
    RowTarget to;
    to.positions = some;
    (void)surface.rows(rows, to);
    round_for(format, some);
  });
}

double written_distance(const SurfaceBlocks& surface, std::span<const glm::dvec3> given,
                        const GltfOptions& options) {
  return largest_distance(surface.info(), given, [&](RowRange rows, std::span<glm::dvec3> some) {
    written_positions(surface, options, rows, some);
  });
}

double largest_distance(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
  const auto count = static_cast<std::int64_t>(std::min(a.size(), b.size()));
  return largest_of_pieces(count, [&](RowRange rows) {
    const auto first = static_cast<std::size_t>(rows.first);
    return largest_of(static_cast<std::size_t>(rows.count),
                      [&](std::size_t i) { return a[first + i] - b[first + i]; });
  });
}

void round_for(FileFormat format, std::span<glm::dvec3> positions) {
  if (info_of(format).keeps_doubles) return;
  for (glm::dvec3& position : positions) position = glm::dvec3(glm::vec3(position));
}

}  // namespace planish
