#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <limits>
#include <utility>

#include "make_scenes/models.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/solve/backend.h"
#include "quality/part_maker.h"
#include "quality/tables.h"

namespace planish::quality {
namespace {

void print_figures(const Figures& figures) {
  std::printf(" %.2f, %.0f, %.1e |", figures.rms_normal, figures.max_normal, figures.folded_area);
}

std::string choice_of(const FittedMesh& made) {
  std::string text = made.options.method == InterpolationMethod::Fair ? "fair" : "progressive";
  if (!made.mesh.creases.empty())
    text += ", " + std::to_string(made.mesh.creases.size()) + " creases";
  if (made.paired_count > 0) text += ", " + std::to_string(made.paired_count) + " quads";
  if (!made.added_vertices.empty()) text += ", refined";
  return text;
}

}  // namespace

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

Outcome fitted(const Case& what, const std::string& flags, const MeshFitOptions& options,
               Backend& backend) {
  Outcome outcome{flags, {}, {}, 0};
  const auto start = std::chrono::steady_clock::now();
  const FittedMesh made = fit_mesh(what.mesh, what.name, backend, options);
  outcome.milliseconds = milliseconds_since(start);
  outcome.choice = choice_of(made);
  outcome.figures = measure(what, made, backend);
  return outcome;
}

std::vector<std::pair<std::string, MeshFitOptions>> mesh_flags() {
  std::vector<std::pair<std::string, MeshFitOptions>> all;
  for (const auto& [method, name] : {std::pair{InterpolationMethod::Progressive, "progressive"},
                                     {InterpolationMethod::Fair, "fair"}}) {
    for (const bool creases : {false, true}) {
      for (const bool quads : {false, true}) {
        MeshFitOptions options;
        options.method = method;
        options.chooses_creases = false;
        options.finds_features = creases;
        options.quads = quads ? QuadChoice::On : QuadChoice::Off;
        all.emplace_back(
            std::string(name) + (creases ? ", creases" : "") + (quads ? ", quads" : ""), options);
      }
    }
  }
  return all;
}

OutcomeTable::OutcomeTable(bool has_before) : has_before_(has_before) {
  if (has_before) {
    std::printf(
        "| shape (vertices) | before: normals off, largest, folded | now | best of all flags | |\n"
        "|---|--:|--:|--:|---|\n");
  } else {
    std::printf(
        "| shape (vertices) | without a flag | normals off, largest, folded | best of all flags | "
        "|\n|---|---|--:|--:|---|\n");
  }
}

void OutcomeTable::add(const Case& what, const Outcome* before, const Outcome& now,
                       const std::vector<Outcome>& others) {
  const auto off = [](const Outcome& outcome) { return outcome.figures.rms_normal; };
  const Outcome& best = *std::ranges::min_element(others, {}, off);
  const bool is_wrong = is_farther_off(off(now), off(best));
  std::printf("| %s%s (%d) |", what.name.c_str(), what.is_held_out ? "*" : "",
              what.mesh.vertex_count());
  if (has_before_) {
    print_figures(before->figures);
    before_ += before->milliseconds;
  } else {
    std::printf(" %s |", now.choice.c_str());
  }
  print_figures(now.figures);
  std::printf(" %.2f | %s%s |\n", off(best), best.flags.c_str(), is_wrong ? ", missed" : "");
  std::fflush(stdout);
  tallies_[what.is_held_out ? 1 : 0].add(off(now), off(best));
  now_ += now.milliseconds;
  if (!is_wrong) return;
  char text[300];
  std::snprintf(text, sizeof text, "%s: normals off by %.2f degrees, %.2f with %s",
                what.name.c_str(), off(now), off(best), best.flags.c_str());
  wrong_.emplace_back(text);
}

std::vector<std::string> OutcomeTable::finish() {
  for (const bool is_held_out : {false, true}) {
    const Tally& tally = tallies_[is_held_out ? 1 : 0];
    std::printf(
        "%s%s: within %.1f of the best, or %.1f degrees, %d of %d; elsewhere farther off "
        "by a factor of %.2f at most\n",
        is_held_out ? "" : "\n", is_held_out ? "held out (*)" : "others", kAlike, kAlikeDegrees,
        tally.right, tally.count, tally.excess);
  }
  if (has_before_) std::printf("time of all fits now over before: %.2f\n", now_ / before_);
  return std::move(wrong_);
}

namespace {

// Of a surface of those faces and that method.
double normals_off(const Case& made, const Candidate& candidate, Backend& backend) {
  MeshFitOptions options;
  options.method = candidate.method;
  options.finds_features = true;
  options.quads = candidate.faces == CandidateFaces::Quads ? QuadChoice::On : QuadChoice::Off;
  options.refine =
      candidate.faces == CandidateFaces::Refined ? RefineChoice::On : RefineChoice::Off;
  return measure(made, fit_mesh(made.mesh, made.name, backend, options), backend).rms_normal;
}

}  // namespace

std::vector<std::string> print_choice_table(const std::vector<NamedCase>& cases) {
  std::printf(
      "| mesh (vertices) | surfaces: folded, bending, cost; normals off the shape | taken |\n"
      "|---|---|---|\n");
  const auto backend = make_cpu_backend({Precision::Double});
  std::vector<std::string> wrong;
  Tally tally;
  for (const NamedCase& named : cases) {
    const Case made = named.make();
    if (!made.truth && !made.has_smooth_source) continue;
    const FittedMesh fitted = fit_mesh(made.mesh, made.name, *backend, {});
    const Choice& choice = *fitted.choice;
    std::printf("| %s%s (%d) |", named.name.c_str(), made.is_held_out ? "*" : "",
                made.mesh.vertex_count());
    double taken = 0, better = std::numeric_limits<double>::infinity();
    std::string name;
    for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
      const Candidate& candidate = choice.candidates[i];
      const std::string what = std::string(word_of(kFacesWords, candidate.faces)) + " " +
                               std::string(word_of(kMethodWords, candidate.method));
      const double off = normals_off(made, candidate, *backend);
      std::printf("%s %s: ", i > 0 ? "<br>" : "", what.c_str());
      if (candidate.is_measured())
        std::printf("%.1e, %.4g, %.2f; ", candidate.folded_area, candidate.bending,
                    candidate.cost());
      std::printf("%.2f", off);
      better = std::min(better, off);
      if (i == choice.taken) taken = off, name = what;
    }
    std::printf(" | %s |\n", name.c_str());
    std::fflush(stdout);
    tally.add(taken, better);
    if (is_farther_off(taken, better)) {
      char text[200];
      std::snprintf(text, sizeof text, "%s: normals off by %.2f degrees, another's by %.2f",
                    named.name.c_str(), taken, better);
      wrong.emplace_back(text);
    }
  }
  std::printf(
      "\nthe best one, or one as good, of %d of %d; elsewhere farther off by a factor of %.2f at "
      "most\n",
      tally.right, tally.count, tally.excess);
  return wrong;
}

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
