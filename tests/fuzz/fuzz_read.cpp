#include "fuzz/fuzz_read.h"

#include <cmath>
#include <cstdlib>

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
    const FileBytes file{.bytes = bytes,
                         .name = "fuzz",
                         .path = {},
                         .split_normals_crease = bytes.size() % 2 == 1};
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
