#include "fuzz/fuzz_read.h"

#include <cmath>
#include <cstdlib>
#include <string>

#include "files/gltf/glb_bytes.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_points.h"
#include "planish/mesh/check.h"
#include "planish/mesh/statistics.h"

namespace planish::test {

namespace {

bool is_finite(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

void fuzz_read_mesh(std::span<const std::byte> bytes, FileFormat format) {
  PolygonMesh mesh;
  try {
    // Every second size as `--creases normals` reads it.
    const FileBytes file{
        .bytes = bytes, .name = "fuzz", .path = {}, .split_normals_crease = bytes.size() % 2 == 1};
    mesh = read_mesh(file, format).mesh;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) std::abort();
    return;
  }
  for (const glm::dvec3& p : mesh.positions)
    if (!is_finite(p)) std::abort();
  const std::vector<MeshProblem> problems = check(mesh);
  for (const MeshProblem& problem : problems)
    if (problem.kind == MeshProblemKind::IndexOutOfRange) std::abort();
  if (problems.empty() && statistics(mesh).genus < 0) std::abort();
}

void fuzz_read_draco(std::span<const std::byte> bytes, FileFormat format) {
  constexpr std::size_t kCounts = 4;
  if (bytes.size() < kCounts) return;
  const auto count_at = [&](std::size_t i) {
    return std::to_integer<int>(bytes[i]) + 256 * std::to_integer<int>(bytes[i + 1]);
  };
  const std::string size = std::to_string(bytes.size() - kCounts);
  const std::string json =
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":)"
      R"({"POSITION":1},"indices":0,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,)"
      R"("attributes":{"POSITION":0}}}}]}],"accessors":[{"componentType":5125,"type":"SCALAR",)"
      R"("count":)" +
      std::to_string(3 * count_at(2)) + R"(},{"componentType":5126,"type":"VEC3","count":)" +
      std::to_string(count_at(0)) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + size +
      R"(}],"buffers":[{"byteLength":)" + size + "}]}";
  std::string glb =
      glb_of(json, {reinterpret_cast<const char*>(bytes.data()) + kCounts, bytes.size() - kCounts});
  fuzz_read_mesh(std::as_bytes(std::span(glb)), format);
}

void fuzz_read_points(std::span<const std::byte> bytes, FileFormat format) {
  PointCloud cloud;
  try {
    cloud = read_points(bytes, "fuzz", format);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) std::abort();
    return;
  }
  if (!is_finite(cloud.origin) || cloud.missing_count < 0) std::abort();
  for (const glm::dvec3& p : cloud.points)
    if (!is_finite(p) || !is_finite(p + cloud.origin)) std::abort();
}

}  // namespace planish::test
