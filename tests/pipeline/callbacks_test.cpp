// What every function that takes callbacks or a backend owes its host: calls on the host's thread
// alone, one at a time, in rising order up to 1; and no more threads than it was given.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <time.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/files/write_surface.h"
#include "planish/job/fit_file.h"
#include "planish/measure/figures.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/kept_rows.h"
#include "support/calls.h"
#include "support/cut_quads.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

namespace fs = std::filesystem;
using test::WatchingHost;

PolygonMesh bumpy(int n) {
  return test::grid(n, n, [n](double x, double y) {
    return glm::dvec3(x, y, 0.1 * n * std::sin(9 * x / n) * std::cos(7 * y / n));
  });
}

// More threads than a small machine has, and a mesh of which every loop has many pieces.
class CallbacksOf : public testing::Test {
 protected:
  FittedMesh fitted_{fit_mesh(bumpy(90), "mesh", *make_cpu_backend(), {})};
  test::TemporaryFolder folder_;
  WatchingHost host_;
  std::unique_ptr<Backend> backend_ = make_cpu_backend();

 private:
  oneapi::tbb::global_control threads_{oneapi::tbb::global_control::max_allowed_parallelism, 4};
};

TEST_F(CallbacksOf, Fits) {
  const PolygonMesh mesh = bumpy(90);
  for (const InterpolationMethod method :
       {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    FitOptions options;
    options.method = method;
    options.callbacks = host_.callbacks();
    (void)fit(mesh, *backend_, options);
    host_.expect_good("fit");
    MeshFitOptions how;
    how.method = method;
    how.crease_degrees = 30;
    how.fit.callbacks = host_.callbacks();
    (void)fit_mesh(mesh, "mesh", *backend_, how);
    host_.expect_good("fit_mesh");
  }
  for (const Solver solver : {Solver::Plain, Solver::ConjugateGradients}) {
    FitOptions options;
    options.solver = solver;
    options.callbacks = host_.callbacks();
    (void)fit(test::torus(60, 40, 3, 1), *backend_, options);
    host_.expect_good("fit by another solver");
  }
  for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Loop}) {
    FitOptions options;
    options.scheme = scheme;
    options.callbacks = host_.callbacks();
    (void)fit(test::icosphere(4), *backend_, options);
    host_.expect_good("fit by another scheme");
  }
}

// Where triangles may be joined the mesh is prepared twice, which is told.
TEST_F(CallbacksOf, PreparesBothMeshes) {
  MeshFitOptions how;
  std::vector<double> told;
  how.fit.callbacks.progress = [&](std::string_view step, double fraction) {
    if (step == "check") told.push_back(fraction);
  };
  const ReadyFit ready = prepare_fit(test::cut_quads(bumpy(30)), "mesh", how);
  EXPECT_NE(ready.paired, nullptr);
  EXPECT_TRUE(std::ranges::is_sorted(told));
  EXPECT_EQ(told.front(), 0);
  EXPECT_EQ(told.back(), 1);
  for (const double part : {0.4, 0.5}) EXPECT_EQ(std::ranges::count(told, part), 1) << part;
  told.clear();
  (void)prepare_fit(bumpy(30), "mesh", how);
  EXPECT_TRUE(std::ranges::is_sorted(told));
  EXPECT_EQ(std::ranges::count(told, 0.5), 0);
  EXPECT_EQ(told.back(), 1);
}

// Both methods, with all that they look at.
TEST_F(CallbacksOf, Choices) {
  for (const PolygonMesh& mesh :
       {bumpy(60), test::jittered(test::icosphere(4), 0.3, 4), test::cube()}) {
    MeshFitOptions how;
    how.fit.callbacks = host_.callbacks();
    (void)fit_mesh(mesh, "mesh", *backend_, how);
    host_.expect_good("fit_mesh");
  }
}

TEST_F(CallbacksOf, Files) {
  write_mesh(folder_.path() / "in.obj", FileFormat::Obj, bumpy(90));
  for (const char* name :
       {"a.glb", "a.gltf", "a.obj", "a.ply", "a.off", "a.stl", "a.usda", "a.step"}) {
    FitFileOptions how;
    how.settings.set_levels({2});
    how.callbacks = host_.callbacks();
    (void)fit_file(folder_.path() / "in.obj", folder_.path() / name, how);
    host_.expect_good(std::string("fit_file ") + name);
    (void)write_fitted_surface(
        folder_.path() / name, fitted_, *backend_,
        {.settings = settings_of({{"levels", "2"}}), .callbacks = host_.callbacks()});
    host_.expect_good(std::string("write_fitted_surface ") + name);
  }
}

TEST_F(CallbacksOf, Surfaces) {
  for (const int level : {0, 1, 3}) {
    EvaluateOptions options = fitted_.evaluate_options(level);
    options.callbacks = host_.callbacks();
    (void)evaluate(fitted_.mesh, fitted_.fit, *backend_, options);
    host_.expect_good("evaluate");
  }
  EvaluateOptions primal{.level = 2, .scheme = Scheme::CatmullClark};
  primal.callbacks = host_.callbacks();
  (void)evaluate(fitted_.mesh, *backend_, primal);
  host_.expect_good("evaluate Catmull-Clark");
  (void)tessellate(fitted_, {.chord_error = 1e-4, .callbacks = host_.callbacks()});
  host_.expect_good("tessellate");
  const auto surface = fitted_surface(fitted_.mesh, fitted_.fit, fitted_.evaluate_options());
  const auto blocks = surface->level(2);
  (void)surface_quality(*blocks, fitted_.mesh, {}, host_.callbacks());
  host_.expect_good("surface_quality");
  const auto kept = keep_rows(*blocks, {.callbacks = host_.callbacks()});
  host_.expect_good("keep_rows");
  (void)collect(*kept, host_.callbacks());
  host_.expect_good("collect");
}

TEST_F(CallbacksOf, Writers) {
  const auto surface = fitted_surface(fitted_.mesh, fitted_.fit, fitted_.evaluate_options());
  const auto blocks = surface->level(2);
  for (const GltfCompression compression :
       {GltfCompression::None, GltfCompression::Quantize, GltfCompression::Meshopt}) {
    for (const std::uint64_t buffer_bytes : {std::uint64_t{1} << 31, std::uint64_t{1} << 20}) {
      GltfOptions options;
      options.compression = compression;
      options.position_error = 0.01;
      options.buffer_bytes = buffer_bytes;
      options.callbacks = host_.callbacks();
      (void)write_gltf(folder_.path() / "w.gltf", *blocks, options);
      host_.expect_good("write_gltf");
      (void)encode_glb(*blocks, options);
      host_.expect_good("encode_glb");
    }
  }
  for (const FileFormat format :
       {FileFormat::Obj, FileFormat::Ply, FileFormat::Off, FileFormat::Stl, FileFormat::Usda}) {
    SurfaceWriteOptions options;
    options.callbacks = host_.callbacks();
    (void)write_surface(folder_.path() / "w", format, *blocks, options);
    host_.expect_good("write_surface");
  }
  TilesOptions tiles{.level = 3, .tile_vertices = 1024, .given = fitted_.mesh.positions};
  tiles.gltf.callbacks = host_.callbacks();
  (void)write_tiles(folder_.path() / "t.json", *surface, tiles);
  host_.expect_good("write_tiles");
}

TEST_F(CallbacksOf, CancelledEndsAllOfThemAndLeavesNoFile) {
  write_mesh(folder_.path() / "in.obj", FileFormat::Obj, bumpy(90));
  const auto surface = fitted_surface(fitted_.mesh, fitted_.fit, fitted_.evaluate_options());
  const auto expect_cancelled = [&](const std::string& name, const auto& work) {
    WatchingHost host;
    host.cancel_after(1);
    (void)test::message_of(ErrorCode::Cancelled, [&] { work(host.callbacks()); });
    host.expect_good(name, false);
  };
  expect_cancelled("fit_file", [&](const Callbacks& callbacks) {
    FitFileOptions how;
    how.callbacks = callbacks;
    (void)fit_file(folder_.path() / "in.obj", folder_.path() / "o.glb", how);
  });
  expect_cancelled("write_fitted_step", [&](const Callbacks& callbacks) {
    StepFileOptions step;
    step.callbacks = callbacks;
    (void)write_fitted_step(folder_.path() / "o.step", fitted_, step);
  });
  expect_cancelled("write_tiles", [&](const Callbacks& callbacks) {
    TilesOptions tiles{.level = 3, .tile_vertices = 1024, .given = fitted_.mesh.positions};
    tiles.gltf.callbacks = callbacks;
    (void)write_tiles(folder_.path() / "t.json", *surface, tiles);
  });
  expect_cancelled("write_surface", [&](const Callbacks& callbacks) {
    SurfaceWriteOptions options;
    options.callbacks = callbacks;
    (void)write_surface(folder_.path() / "o.ply", FileFormat::Ply, *surface->level(3), options);
  });
  expect_cancelled("tessellate", [&](const Callbacks& callbacks) {
    (void)tessellate(fitted_, {.chord_error = 1e-5, .callbacks = callbacks});
  });
  std::vector<std::string> left;
  for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
    left.push_back(entry.path().filename());
  EXPECT_EQ(left, std::vector<std::string>{"in.obj"});
}

double seconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Seconds that all threads but this one have worked meanwhile, of those that this one has.
double share_of_others(const std::function<void()>& work) {
  const double process = seconds_of(CLOCK_PROCESS_CPUTIME_ID),
               thread = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  work();
  const double own = seconds_of(CLOCK_THREAD_CPUTIME_ID) - thread;
  return (seconds_of(CLOCK_PROCESS_CPUTIME_ID) - process - own) / own;
}

TEST_F(CallbacksOf, OneThreadIsOneThread) {
  const PolygonMesh mesh = bumpy(90);
  write_mesh(folder_.path() / "in.obj", FileFormat::Obj, mesh);
  const auto one = make_cpu_backend({.thread_count = 1});
  // Threads that have just worked look for more for a moment.
  const auto expect_alone = [](const std::string& name, const std::function<void()>& work) {
    double share = 1;
    for (int attempt = 0; attempt < 5 && share > 0.02; ++attempt) share = share_of_others(work);
    EXPECT_LT(share, 0.02) << name;
  };
  for (const InterpolationMethod method :
       {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    FitOptions options;
    options.method = method;
    expect_alone("fit", [&] { (void)fit(mesh, *one, options); });
  }
  expect_alone("fit_mesh", [&] { (void)fit_mesh(mesh, "mesh", *one, {}); });
  for (const char* name : {"a.glb", "a.ply", "a.step"}) {
    FitFileOptions how;
    how.backend = one.get();
    expect_alone("fit_file",
                 [&] { (void)fit_file(folder_.path() / "in.obj", folder_.path() / name, how); });
    expect_alone("write_fitted_surface", [&] {
      (void)write_fitted_surface(folder_.path() / name, fitted_, *one,
                                 {.settings = settings_of({{"levels", "2"}})});
    });
  }
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark})
    expect_alone("evaluate", [&] {
      (void)evaluate(mesh, *one, EvaluateOptions{.level = 2, .scheme = scheme});
    });
}

}  // namespace
}  // namespace planish
