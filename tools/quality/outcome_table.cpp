#include "quality/outcome_table.h"

#include <algorithm>
#include <cstdio>

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

}  // namespace planish::quality
