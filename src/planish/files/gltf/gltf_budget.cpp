#include "planish/files/gltf/gltf_budget.h"

#include <algorithm>

#include "planish/core/error.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

// What a reader holds of each at its peak, lists that grow among it. A vertex of the largest
// primitive: its number and stamp; one that is placed: its position, its slot in a table. A corner:
// its vertex before and behind welding, its place in the mesh, its texture coordinate and group.
constexpr std::uint64_t kVertexBytes = 12, kPlacedBytes = 72, kCornerBytes = 28, kPointBytes = 110,
                        kUvBytes = 40, kNormalBytes = 48, kNumberBytes = 16;
// Scenes that need less are read without asking the system.
constexpr std::uint64_t kSmallScene = std::uint64_t{64} << 20;

std::string gibibytes_text(std::uint64_t bytes) {
  const std::uint64_t tenths = bytes / ((std::uint64_t{1} << 30) / 10);
  return formatted("{}.{} GiB", tenths / 10, tenths % 10);
}

}  // namespace

void GltfBudget::add_triangles(const JsonPlace& place, std::int64_t vertices,
                               std::int64_t corners) {
  if (vertices > limits_.corners)
    place.fail("names {} vertices; at most {} are read", vertices, limits_.corners);
  add(place, corners_, corners, "triangle corners and points");
  take(place, corners, kCornerBytes);
  take(place, std::min(vertices, corners), kPlacedBytes);
  if (vertices > largest_) take(place, vertices - largest_, kVertexBytes);
  largest_ = std::max(vertices, largest_);
}

void GltfBudget::add_points(const JsonPlace& place, std::int64_t points) {
  add(place, corners_, points, "triangle corners and points");
  take(place, points, kPointBytes);
}

void GltfBudget::add_uvs(const JsonPlace& place, std::int64_t uvs) {
  add(place, uvs_, uvs, "texture coordinates");
  take(place, uvs, kUvBytes);
}

void GltfBudget::add_normals(const JsonPlace& place, std::int64_t normals) {
  add(place, normals_, normals, "normals");
  take(place, normals, kNormalBytes);
}

void GltfBudget::add_numbers(const JsonPlace& place, std::int64_t numbers) {
  take(place, numbers, kNumberBytes);
}

void GltfBudget::add(const JsonPlace& place, std::int64_t& total, std::int64_t count,
                     const char* what) const {
  // Counts are at most 3 * 2^53 and what was let through is small.
  total += count;
  if (total > limits_.corners)
    place.fail(
        "the scene has more than {} {}, which 32-bit numbers do not reach; split it into "
        "several files",
        limits_.corners, what);
}

void GltfBudget::take(const JsonPlace& place, std::int64_t count, std::uint64_t bytes_each) {
  bytes_ += static_cast<std::uint64_t>(count) * bytes_each;
  if (limits_.memory_bytes == 0 && bytes_ <= kSmallScene) return;
  if (free_bytes_ == 0)
    free_bytes_ = limits_.memory_bytes > 0 ? limits_.memory_bytes : available_memory_bytes();
  if (bytes_ <= free_bytes_) return;
  throw Error(ErrorCode::OutOfMemory,
              formatted("{}: {}: the scene up to here needs about {} of memory where {} are free; "
                        "split it into several files",
                        file_, place.path(), gibibytes_text(bytes_), gibibytes_text(free_bytes_)));
}

}  // namespace planish
