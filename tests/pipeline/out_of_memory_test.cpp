// Memory runs out at every place where a small job takes some, one after another: the job ends by
// an exception, leaves no file, and the next job has the bits that it should have.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cstdint>
#include <filesystem>
#include <utility>

#include "planish/backend/cpu_backend.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit_file.h"
#include "support/failing_memory.h"
#include "support/meshes.h"
#include "support/temporary_folder.h"

namespace planish {
namespace {

// Faces of several sizes, so that batches of several classes are open when one fails.
PolygonMesh some_mesh() {
  PolygonMesh mesh = test::prism(3);
  mesh.creases = {{mesh.face_vertices[0], mesh.face_vertices[1], kInfiniteSharpness}};
  return mesh;
}

TEST(OutOfMemory, AJobThatFailsAnywhereLeavesTheNextOneRight) {
  const auto backend = make_cpu_backend({.thread_count = 1});
  const auto expect_recovery = [&](InterpolationMethod method, const PolygonMesh& mesh) {
    const auto job = [&](const PolygonMesh& of) {
      FitOptions options;
      options.method = method;
      const Fit fitted = fit(of, *backend, options);
      const SurfaceMesh surface = evaluate(of, fitted, *backend, {.level = 2});
      return std::pair(surface.positions, surface.normals);
    };
    // Another mesh, of other classes: what the failure left behind must not show.
    const PolygonMesh other = test::prism(5);
    const auto expected = job(other);
    const std::int64_t requests = test::fail_at_every_request(
        [&] { (void)job(mesh); },
        [&](std::int64_t n) { ASSERT_TRUE(job(other) == expected) << n; });
    EXPECT_GT(requests, 300);
  };
  expect_recovery(InterpolationMethod::Progressive, test::torus(4, 3, 3, 1));
  expect_recovery(InterpolationMethod::Fair, some_mesh());
}

TEST(OutOfMemory, NoFileIsLeft) {
  const test::TemporaryFolder folder;
  const auto backend = make_cpu_backend({.thread_count = 1});
  const FittedMesh fitted = fit_mesh(some_mesh(), "mesh", *backend, {});
  for (const char* name : {"a.ply", "a.obj", "a.stl"}) {
    const std::int64_t requests = test::fail_at_every_request(
        [&] {
          std::filesystem::remove(folder.path() / name);  // of a job that could do without
          (void)write_fitted_surface(folder.path() / name, fitted, "mesh", *backend, {.level = 1});
        },
        [&](std::int64_t n) { EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << n; });
    EXPECT_GT(requests, 30);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / name));
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      std::filesystem::remove(entry.path());
  }
}

// JSON too, whose values are taken apart by memory that they ask for: one failure is no second one.
TEST(OutOfMemory, ReadersEndByAnException) {
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism,
                                               1);
  const test::TemporaryFolder folder;
  const auto backend = make_cpu_backend({.thread_count = 1});
  const FittedMesh fitted = fit_mesh(some_mesh(), "mesh", *backend, {});
  for (const char* name : {"a.glb", "a.gltf", "a.obj", "a.ply", "a.off", "a.stl"}) {
    SCOPED_TRACE(name);
    const std::filesystem::path path = folder.path() / name;
    (void)write_fitted_surface(path, fitted, "mesh", *backend, {.level = 1});
    const std::int64_t faces = read_mesh(path).mesh.face_count();
    const std::int64_t requests = test::fail_at_every_request(
        [&] { EXPECT_EQ(read_mesh(path).mesh.face_count(), faces); }, [](std::int64_t) {});
    EXPECT_GT(requests, 10);
  }
}

}  // namespace
}  // namespace planish
