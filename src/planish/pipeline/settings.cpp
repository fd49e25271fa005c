#include "planish/pipeline/settings.h"

#include <algorithm>

#include "planish/core/refuse.h"
#include "planish/pipeline/option_table.h"
#include "planish/pipeline/option_words.h"

namespace planish {

MeshFitOptions mesh_fit_options(const FitSettings& settings) {
  MeshFitOptions options;
  if (settings.interpolation == InterpolationChoice::Progressive)
    options.method = InterpolationMethod::Progressive;
  if (settings.interpolation == InterpolationChoice::Fair)
    options.method = InterpolationMethod::Fair;
  options.repairs = settings.repair == RepairChoice::Safe;
  options.finds_features = settings.creases.finds_features;
  options.crease_degrees = settings.creases.dihedral_degrees;
  options.chooses_creases = settings.creases.chooses;
  options.quads = settings.quads;
  options.refine = settings.refine;
  // The mesh under a baked map is the input's.
  if (settings.bake > 0 && settings.refine == RefineChoice::Auto)
    options.refine = RefineChoice::Off;
  options.weld = settings.weld;
  options.fit.scheme = settings.scheme;
  options.fit.weights = settings.weights;
  options.fit.solver = settings.solver;
  options.fit.tolerance = settings.tolerance;
  options.fit.max_iterations = settings.max_iterations;
  options.fit.polish_steps = settings.polish_steps;
  options.fit.sharp = {settings.boundary, settings.creases.use_tags};
  options.fit.within = settings.within.of_diagonal.value_or(0.0);
  if (settings.within.is_measured) options.fit.within.reset();
  return options;
}

FitOptions fit_options(const FitSettings& settings, InterpolationMethod method) {
  FitOptions options = mesh_fit_options(settings).fit;
  options.method = method;
  options.sharp = settings.sharp();
  return options;
}

VerifyOptions verify_options(const FitSettings& settings) {
  if (settings.within.is_measured)
    refuse("within", "\"auto\" does not say how far; take what the fit allowed");
  VerifyOptions options;
  options.method = settings.interpolation == InterpolationChoice::Fair
                       ? InterpolationMethod::Fair
                       : InterpolationMethod::Progressive;
  options.scheme = settings.scheme;
  options.weights = settings.weights;
  options.sharp = {settings.boundary, settings.creases.use_tags};
  options.repairs = settings.repair == RepairChoice::Safe;
  options.finds_features = settings.creases.finds_features;
  options.crease_degrees = settings.creases.dihedral_degrees;
  options.weld = settings.weld;
  options.quads = settings.quads;
  options.refine = settings.refine;
  options.tolerance = std::max(settings.tolerance, settings.within.of_diagonal.value_or(0.0));
  return options;
}

Precision solve_precision(const FitSettings& settings) {
  if (settings.precision == PrecisionChoice::Float) return Precision::Float;
  if (settings.precision == PrecisionChoice::Double) return Precision::Double;
  return precision_for(settings.tolerance);
}

void check_consistent(const FitSettings& settings, SpellOption spell) {
  if (settings.device == "vulkan" && settings.precision != PrecisionChoice::Auto) {
    refuse(spell("precision"),
           "{} is for the CPU backend; leave it out with {} vulkan, or take {} cpu",
           option_text(settings, "precision"), spell("device"), spell("device"));
  }
  if (settings.within.of_diagonal.value_or(0) > 0 &&
      *settings.within.of_diagonal <= settings.tolerance) {
    refuse(spell("within"), option_text(settings, "within") + " is not above " +
                                spell("tolerance") + " " + option_text(settings, "tolerance") +
                                ", within which the surface passes the vertices anyway");
  }
  if (settings.adaptive.any() && settings.attributes.any()) {
    refuse(spell("attributes"), "fields are made on levels; take {} instead of {} and {}",
           spell("levels"), spell("chord_errors"), spell("angle"));
  }
  if (settings.bake > 0 && settings.refine == RefineChoice::On) {
    refuse(spell("refine"), "a baked map is of the input's own vertices; leave it or {} out",
           spell("bake"));
  }
  if (settings.bake > 0 && settings.adaptive.any()) {
    refuse(spell("bake"), "a baked map is of level 0; leave {} and {} out", spell("chord_errors"),
           spell("angle"));
  }
  if (settings.scheme == Scheme::DooSabin) return;
  const std::string scheme = option_text(settings, "scheme");
  const std::string doo_sabin = spell("scheme") + " doo-sabin";
  if (settings.scheme == Scheme::Loop && settings.quads == QuadChoice::On) {
    refuse(spell("quads"), "loop surfaces are of triangles; take off, or " + doo_sabin);
  }
  if (settings.adaptive.any()) {
    refuse(spell(settings.adaptive.chord_errors.empty() ? "angle" : "chord_errors"),
           scheme + " surfaces come in levels; take " + spell("levels") + ", or " + doo_sabin);
  }
  if (settings.weights != Weights::DooSabin) {
    refuse(spell("weights"), "{} belongs to {}; leave it and {} paper out with {} {}",
           option_text(settings, "weights"), doo_sabin, spell("preset"), spell("scheme"), scheme);
  }
  if (settings.interpolation == InterpolationChoice::Fair) {
    refuse(spell("interpolation"),
           "fair builds control points of Doo-Sabin's level 1, "
           "which {} does not have; take progressive, or {}",
           scheme, doo_sabin);
  }
}

void settle(FitSettings& settings, const FittedMesh& fitted) {
  settings.creases.chooses = false;
  settings.creases.finds_features = fitted.finds_features;
  settings.creases.dihedral_degrees = fitted.crease_degrees;
  settings.quads = fitted.pairs_triangles ? QuadChoice::On : QuadChoice::Off;
  settings.refine = fitted.added_vertices.empty() ? RefineChoice::Off : RefineChoice::On;
  if (fitted.fit.within) settings.within = {.of_diagonal = fitted.fit.within->within};
}

}  // namespace planish
