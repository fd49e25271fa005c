// Memory runs out at every place where a small job takes some, one after another: the job ends by
// an exception, leaves no file, and the next job has the bits that it should have.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "planish/files/gltf/gltf_tangents.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "support/failing_memory.h"
#include "support/files.h"
#include "support/meshes.h"

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
          (void)write_fitted_surface(folder.path() / name, fitted, *backend,
                                     {.settings = settings_of({{"levels", "1"}})});
        },
        [&](std::int64_t n) { EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << n; });
    EXPECT_GT(requests, 30);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / name));
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      std::filesystem::remove(entry.path());
  }
}

// A torus whose quads have texture coordinates of their own.
class Textured {
 public:
  Textured(int around, int across)
      : mesh_(with_uvs(test::torus(around, across, 3, 1))),
        base_(mesh_, {}),
        blocks_(base_.level(1)) {
    uvs_.resize(static_cast<std::size_t>(blocks_->info().uv_count));
    blocks_->uvs({0, blocks_->info().uv_count}, uvs_);
  }
  [[nodiscard]] RawVector<float> tangents() const {
    return surface_tangents(*blocks_, {.sets = {uvs_}, .set_of_group = {0}}).values;
  }

 private:
  static PolygonMesh with_uvs(PolygonMesh mesh) {
    for (const std::int32_t v : mesh.face_vertices) {
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
      mesh.uvs.emplace_back(mesh.positions[v]);
    }
    return mesh;
  }

  PolygonMesh mesh_;
  DooSabinSurface base_;
  std::unique_ptr<SurfaceBlocks> blocks_;
  std::vector<glm::dvec2> uvs_;
};

// What a failure left in a thread's lanes is no part of the next surface, which has less room.
TEST(OutOfMemory, TangentsThatFailAnywhereLeaveTheNextOnesRight) {
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism,
                                               1);
  const Textured large(8, 6), small(4, 3);
  const RawVector<float> expected = small.tangents();
  bool has_failed = true;
  for (std::int64_t n = 0; has_failed; ++n) {
    std::thread([&] {  // which has no lanes yet
      has_failed = test::with_failing_request(n, [&] {
        try {
          (void)large.tangents();
        } catch (const std::bad_alloc&) {
        }
      });
      EXPECT_EQ(small.tangents(), expected) << n;
    })
        .join();
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
    (void)write_fitted_surface(path, fitted, *backend,
                               {.settings = settings_of({{"levels", "1"}})});
    const std::int64_t faces = read_mesh(path).mesh.face_count();
    const std::int64_t requests = test::fail_at_every_request(
        [&] { EXPECT_EQ(read_mesh(path).mesh.face_count(), faces); }, [](std::int64_t) {});
    EXPECT_GT(requests, 10);
  }
}

}  // namespace
}  // namespace planish
