#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "planish/core/parallel.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// Calls body(begin, end) for pieces of [0, count) on all threads and sums what it returns;
/// `make_body` makes one for each piece. Pieces are of fixed size: the same bits for every
/// thread count.
template <class MakeBody>
double piecewise_sum_of_ranges(std::int32_t count, const MakeBody& make_body) {
  const auto of_range = [&](std::size_t begin, std::size_t end) -> double {
    return make_body()(static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
  };
  return ordered_reduce(static_cast<std::size_t>(count), 4096, 0.0, of_range,
                        [](double& sum, double piece) { sum += piece; });
}

/// The same of body(i) for i in [0, count).
template <class MakeBody>
double piecewise_sum(std::int32_t count, const MakeBody& make_body) {
  return piecewise_sum_of_ranges(count, [&] {
    return [body = make_body()](std::int32_t begin, std::int32_t end) mutable {
      double sum = 0;
      for (std::int32_t i = begin; i < end; ++i) sum += body(i);
      return sum;
    };
  });
}

/// body(first corner, size of the face), the size as a constant of its type for triangles and quads
/// so that loops over it unroll.
template <class Body>
double for_face_size(const FairTopology& topology, std::int32_t face, const Body& body) {
  const std::int32_t first = topology.face_offsets[face];
  const std::int32_t m = topology.face_size(face);
  if (m == 3) return body(first, std::integral_constant<std::int32_t, 3>{});
  if (m == 4) return body(first, std::integral_constant<std::int32_t, 4>{});
  return body(first, m);
}

}  // namespace planish
