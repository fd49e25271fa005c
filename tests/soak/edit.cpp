// One editor after many moves: nothing that is allocated grows, and the surface stays where it
// must.
#include "planish/edit/editor.h"

#include <malloc.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <random>
#include <string>

#include "planish/pipeline/fit.h"
#include "planish/queries/surface_queries.h"
#include "planish/solve/backend.h"
#include "soak/soak.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

constexpr std::uint64_t kEditorMayGrow = 1u << 20;
// Edits between two looks at memory, at the error, and of the fair method, whose edits take longer.
constexpr std::uint32_t kLook = 200, kMeasure = 5000, kFair = 100;

class EditSoak {
 public:
  EditSoak(const char* name, PolygonMesh mesh, InterpolationMethod method)
      : name_(name), mesh_(std::move(mesh)) {
    options_.level = 1;
    options_.fit.method = method;
    fit_ = fit(mesh_, *make_cpu_backend(), options_.fit);
    editor_ = std::make_unique<Editor>(mesh_, fit_, options_);
    (void)editor_->queries();
  }

  void edit(std::mt19937& random) {
    const auto vertex = static_cast<std::int32_t>(random() % mesh_.positions.size());
    switch (random() % 16) {
      case 0:
        editor_->undo();
        return;
      case 1:
        editor_->redo();
        return;
      case 2: {
        const Selection near =
            editor_->select(std::span(&vertex, 1), 0.05 * fit_.placement.diagonal);
        editor_->transform(near, glm::translate(glm::dmat4(1.0), way(random)));
        break;
      }
      default: {
        // Around where it was in the fit, so that the mesh stays what it is.
        const glm::dvec3 to = mesh_.positions[vertex] + way(random);
        editor_->move(std::span(&vertex, 1), std::span(&to, 1));
      }
    }
    const glm::dvec3 at = editor_->points()[vertex];
    const double off = editor_->queries().closest(at).distance / fit_.placement.diagonal;
    if (!(off <= editor_->error_bound() + kRounding))
      complain(std::string(name_) + ": a moved vertex is " + std::to_string(off) +
               " of the diagonal from the surface");
  }

  void measure() const {
    const double error = editor_->measured_error();
    if (!(error <= editor_->error_bound() * (1 + 1e-9) + kRounding) ||
        !(editor_->error_bound() <= options_.fit.tolerance))
      complain(std::string(name_) + ": the error " + std::to_string(error) + " is above the bound");
  }

  // Against rows from scratch, and after settling.
  void finish() {
    measure();
    FitOptions again = options_.fit;
    if (fit_.fair) again.fair_decisions = &fit_.fair->decisions;
    if (!fit_.fair) again.tolerance = 1e-11;
    const PolygonMesh moved = editor_->mesh();
    const Fit whole = fit(moved, *make_cpu_backend(), again);
    EvaluateOptions evaluate;
    evaluate.level = options_.level;
    evaluate.rest_positions = mesh_.positions;
    const SurfaceMesh rows = planish::evaluate(moved, whole, *make_cpu_backend(), evaluate);
    const double off = farthest_from(rows);
    editor_->settle();
    const double settled = farthest_from(rows);
    std::printf("%s: error %.2e (bound %.2e); rows off a fit from scratch by %.2e, settled %.2e\n",
                name_, editor_->measured_error(), editor_->error_bound(), off, settled);
    const double allowed = fit_.fair ? 0.05 * kWay : 2 * options_.fit.tolerance;
    if (!(off <= allowed)) complain(std::string(name_) + ": rows have drifted");
    if (!(settled <= (fit_.fair ? 1e-7 : 2 * options_.fit.tolerance)))
      complain(std::string(name_) + ": settled, it is not the fit from scratch");
  }

 private:
  static constexpr double kWay = 0.01, kRounding = 1e-12;  // of the diagonal

  [[nodiscard]] glm::dvec3 way(std::mt19937& random) const {
    std::uniform_real_distribution<double> part(-kWay, kWay);
    const double x = part(random), y = part(random);
    return fit_.placement.diagonal * glm::dvec3(x, y, part(random));
  }

  [[nodiscard]] double farthest_from(const SurfaceMesh& rows) const {
    double result = 0;
    for (std::size_t r = 0; r < rows.positions.size(); ++r)
      result = std::max(result, glm::length(rows.positions[r] - editor_->positions()[r]));
    return result / fit_.placement.diagonal;
  }

  const char* name_;
  PolygonMesh mesh_;
  EditorOptions options_;
  Fit fit_;
  std::unique_ptr<Editor> editor_;
};

}  // namespace

void soak_edit(std::uint32_t count, std::uint32_t first) {
  EditSoak smooth("torus", torus(60, 40, 1, 0.4), InterpolationMethod::Progressive);
  EditSoak creased("creased", with_random_creases(jittered(icosphere(4), 0.1, 2), 0.05, 3),
                   InterpolationMethod::Progressive);
  EditSoak fair("fair", torus(60, 40, 1, 0.4), InterpolationMethod::Fair);
  std::mt19937 random(first);
  Growth growth;
  std::uint32_t i = 0;
  for (; i < count && !is_stopped(); ++i) {
    (i % kFair == 0 ? fair : i % 2 == 0 ? smooth : creased).edit(random);
    if (i % kMeasure == 0) {
      smooth.measure();
      creased.measure();
      fair.measure();
    }
    if (i % kLook != 0) continue;
    const struct mallinfo2 info = ::mallinfo2();
    growth.note(info.uordblks + info.hblkhd);
  }
  smooth.finish();
  creased.finish();
  fair.finish();
  std::printf("%u edits; allocated %s\n", i, growth.text().c_str());
  if (growth.bytes() > kEditorMayGrow)
    complain("memory grows by " + std::to_string(growth.bytes()) + " bytes");
}

}  // namespace planish::test
