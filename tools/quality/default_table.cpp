#include "quality/default_table.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <utility>

#include "make_scenes/bust.h"
#include "make_scenes/rocker_arm.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"
#include "planish/backend/cpu_backend.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/reconstruct/reconstruct.h"
#include "quality/outcome_table.h"
#include "quality/part_shapes.h"

namespace planish::quality {

namespace {

void add_mesh(const Case& what, Backend& backend, OutcomeTable& table) {
  MeshFitOptions before;
  before.refine = RefineChoice::Off;
  before.chooses_creases = false;
  before.quads = QuadChoice::Off;
  std::vector<Outcome> others;
  for (const auto& [flags, options] : mesh_flags())
    others.push_back(fitted(what, flags, options, backend));
  const Outcome as_before = fitted(what, "", before, backend);
  table.add(what, &as_before, fitted(what, "", {}, backend), others);
}

struct Cloud {
  std::string name;
  PointCloud points;
  Case truth;
};

std::vector<Cloud> noisy_clouds() {
  constexpr std::int32_t kPoints = 15'000;
  const shapes::TorusOptions ring{.ring_count = 240, .tube_count = 120};
  std::vector<Case> kinds(3);
  kinds[0].name = "arm";
  kinds[0].mesh = shapes::rocker_arm();
  kinds[0].truth = true_zero_set(shapes::rocker_arm_field);
  kinds[1].name = "torus";
  kinds[1].mesh = shapes::torus(ring);
  kinds[1].truth = true_torus(ring.radius, ring.tube_radius);
  kinds[2].name = "bust";
  kinds[2].mesh = kinds[2].source = shapes::bust();
  kinds[2].has_smooth_source = kinds[2].is_held_out = true;
  std::vector<Cloud> clouds;
  for (const Case& kind : kinds) {
    for (const double noise : {0.0, 5e-4, 1e-3, 3e-3, -1.0}) {
      Cloud cloud;
      cloud.truth = kind;
      cloud.points.points = shapes::sample_uniform(kind.mesh, kPoints, 3);
      const double diagonal = diagonal_of(cloud.points.points);
      if (noise > 0) shapes::add_noise(cloud.points.points, noise * diagonal, 4);
      if (noise < 0) shapes::add_outliers(cloud.points.points, kPoints / 100, 5);
      char text[64];
      std::snprintf(text, sizeof text, noise < 0 ? "1 %% outliers" : "noise %g %%", 100 * noise);
      cloud.truth.name = kind.name + ", points, " + text;
      clouds.push_back(std::move(cloud));
    }
  }
  return clouds;
}

Outcome reconstructed(const Cloud& cloud, const std::string& flags,
                      const ReconstructOptions& options, const Mesher& mesher, Backend& backend) {
  Outcome outcome{flags, {}, {}, 0};
  const auto start = std::chrono::steady_clock::now();
  Case made = cloud.truth;
  made.mesh = reconstruct(cloud.points, mesher, options).mesh;
  MeshFitOptions fit;
  fit.method = InterpolationMethod::Fair;  // what the command takes for points
  fit.quads = QuadChoice::Off;             // they are paired already
  const FittedMesh fitted = fit_mesh(made.mesh, made.name, backend, fit);
  outcome.milliseconds = milliseconds_since(start);
  outcome.figures = measure(made, fitted, backend);
  return outcome;
}

void add_cloud(const Cloud& cloud, const Mesher& mesher, Backend& backend, OutcomeTable& table) {
  std::vector<Outcome> others;
  for (const int rounds : {0, 1, 2, 4}) {
    for (const double tolerance : {1e-4, 1e-3, 2e-3}) {
      ReconstructOptions options;
      options.smooth_rounds = rounds;
      options.tolerance = tolerance;
      char text[64];
      std::snprintf(text, sizeof text, "smooth %d, tolerance %g", rounds, tolerance);
      others.push_back(reconstructed(cloud, text, options, mesher, backend));
    }
  }
  ReconstructOptions before;
  before.measure_noise = false;
  before.smooth_rounds = 0;
  const Outcome as_before = reconstructed(cloud, "", before, mesher, backend);
  table.add(cloud.truth, &as_before, reconstructed(cloud, "", {}, mesher, backend), others);
}

// Coarse parts against fine ones.
std::vector<Case> parts() {
  std::vector<Case> cases;
  const auto add = [&](const char* name, bool is_held_out,
                       const std::function<PolygonMesh(std::int32_t)>& make,
                       std::int32_t segments) {
    Case made{name, make(segments), {}};
    made.source = make(256);
    made.has_smooth_source = true;
    made.is_held_out = is_held_out;
    cases.push_back(std::move(made));
  };
  add(
      "L part", false, [](std::int32_t n) { return l_part({n}); }, 16);
  add(
      "L part, long", true,
      [](std::int32_t n) {
        return l_part({n, 1.5});
      },
      32);
  add(
      "drilled plate", false, [](std::int32_t n) { return drilled_plate({n}, 3); }, 16);
  add(
      "drilled plate, 5", true, [](std::int32_t n) { return drilled_plate({n}, 5); }, 32);
  add(
      "gear", false, [](std::int32_t n) { return gear({n}, 14); }, 32);
  add(
      "gear, 20", true, [](std::int32_t n) { return gear({n}, 20); }, 64);
  add(
      "rod", false,
      [](std::int32_t n) {
        return rod({n, 4});
      },
      32);
  add(
      "rod, short", true,
      [](std::int32_t n) {
        return rod({n, 2});
      },
      48);
  add(
      "pipe", false,
      [](std::int32_t n) {
        return pipe({n, 3});
      },
      32);
  add(
      "pipe, long", true,
      [](std::int32_t n) {
        return pipe({n, 5});
      },
      48);
  return cases;
}

}  // namespace

std::vector<std::string> print_default_table(const std::vector<NamedCase>& meshes,
                                             const Mesher* mesher) {
  constexpr std::int32_t kMostVertices = 5000;
  const auto backend = make_cpu_backend();
  OutcomeTable table(true);
  for (const NamedCase& named : meshes) {
    const Case made = named.make();
    if (made.mesh.vertex_count() <= kMostVertices && (made.truth || made.has_smooth_source))
      add_mesh(made, *backend, table);
  }
  for (const Case& part : parts()) add_mesh(part, *backend, table);
  if (mesher != nullptr)
    for (const Cloud& cloud : noisy_clouds()) add_cloud(cloud, *mesher, *backend, table);
  return table.finish();
}

}  // namespace planish::quality
