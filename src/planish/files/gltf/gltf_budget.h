#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "planish/files/gltf/json_place.h"

namespace planish {

/// How much a scene may hold.
struct GltfLimits {
  /// Triangle corners, points, texture coordinates and normals: what int32 counts.
  std::int64_t corners = (std::int64_t{1} << 31) - 1;
  std::uint64_t memory_bytes = 0;  ///< 0: what the machine has free when the first is counted
};

/// Counts what a scene holds before memory is taken for it: a few bytes of nodes can place any
/// number of triangles. Every member throws Error{UnreadableInput} naming `place` past the limits
/// of counts, Error{OutOfMemory} past that of memory.
class GltfBudget {
 public:
  GltfBudget(const GltfLimits& limits, std::string_view file) : limits_(limits), file_(file) {}

  /// A primitive's, each time that a node places it.
  void add_triangles(const JsonPlace& place, std::int64_t vertices, std::int64_t corners);
  void add_points(const JsonPlace& place, std::int64_t points);
  void add_uvs(const JsonPlace& place, std::int64_t uvs);
  void add_normals(const JsonPlace& place, std::int64_t normals);
  /// Of further attributes.
  void add_numbers(const JsonPlace& place, std::int64_t numbers);

 private:
  void add(const JsonPlace& place, std::int64_t& total, std::int64_t count, const char* what) const;
  void take(const JsonPlace& place, std::int64_t count, std::uint64_t bytes_each);

  GltfLimits limits_;
  std::string file_;
  std::int64_t corners_ = 0, uvs_ = 0, normals_ = 0;
  std::int64_t largest_ = 0;                  // vertices of a primitive
  std::uint64_t bytes_ = 0, free_bytes_ = 0;  // free: 0 before it is asked for
};

}  // namespace planish
