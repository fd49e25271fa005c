// Memory runs out at every place where a small job takes some, one after another: the job ends by
// an exception, leaves no file, and the next job has the bits that it should have.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <new>
#include <utility>

#include "planish/backend/cpu_backend.h"
#include "planish/core/error.h"
#include "planish/pipeline/fit_file.h"
#include "support/meshes.h"
#include "support/temporary_folder.h"

namespace {

// Requests until one fails; negative: none does.
thread_local std::int64_t requests_left = -1;

void* take(std::size_t size, std::size_t alignment) {
  if (requests_left == 0) {
    requests_left = -1;  // what handles the exception takes memory, too
    throw std::bad_alloc();
  }
  if (requests_left > 0) --requests_left;
  void* const place =
      alignment > alignof(std::max_align_t)
          ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
          : std::malloc(std::max<std::size_t>(size, 1));
  if (place == nullptr) throw std::bad_alloc();
  return place;
}

}  // namespace

void* operator new(std::size_t size) { return take(size, 0); }
void* operator new[](std::size_t size) { return take(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return take(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return take(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* place) noexcept { std::free(place); }
void operator delete[](void* place) noexcept { std::free(place); }
void operator delete(void* place, std::size_t) noexcept { std::free(place); }
void operator delete[](void* place, std::size_t) noexcept { std::free(place); }
void operator delete(void* place, std::align_val_t) noexcept { std::free(place); }
void operator delete[](void* place, std::align_val_t) noexcept { std::free(place); }
void operator delete(void* place, std::size_t, std::align_val_t) noexcept { std::free(place); }
void operator delete[](void* place, std::size_t, std::align_val_t) noexcept { std::free(place); }

namespace planish {
namespace {

// Runs `job` again and again, its n-th request for memory failing, until it makes no more of them.
// Returns how many it makes. What can do without (the buffer of a stable sort) may come to its end.
std::int64_t fail_at_every_request(const std::function<void()>& job,
                                   const std::function<void(std::int64_t)>& after_failure) {
  for (std::int64_t n = 0;; ++n) {
    requests_left = n;
    bool has_ended = false;
    try {
      job();
      has_ended = true;
    } catch (const std::bad_alloc&) {
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::OutOfMemory) << error.what();
    }
    const bool has_failed = requests_left < 0;
    requests_left = -1;
    if (has_ended && !has_failed) return n;
    EXPECT_TRUE(has_failed) << "the job ended for another reason";
    if (!has_ended) after_failure(n);
    if (testing::Test::HasFailure()) return n;
  }
}

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
    const std::int64_t requests =
        fail_at_every_request([&] { (void)job(mesh); },
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
    const std::int64_t requests = fail_at_every_request(
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

}  // namespace
}  // namespace planish
