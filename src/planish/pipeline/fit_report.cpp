#include "planish/pipeline/fit_report.h"

#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/mend/faults.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/option_table.h"

namespace planish {
namespace {

// A surface whose folded part is larger than this fraction of its area gets a warning.
constexpr double kFoldedAreaLimit = 1e-4;
// A texture that slides by more than this fraction of the diagonal gets a warning.
constexpr double kTextureSlideLimit = 0.05;

std::int64_t given_one(const std::vector<std::int32_t>& sources, std::int64_t element) {
  return sources.empty() ? element : sources[static_cast<std::size_t>(element)];
}

std::optional<Warning> unused_warning(const FittedMesh& fitted, std::string_view name) {
  const PreparedMesh& prepared = *fitted.fit.prepared;
  const std::int64_t count = prepared.given_vertex_count - std::ssize(prepared.vertices);
  if (count == 0) return std::nullopt;
  std::int64_t first = 0;
  while (first < std::ssize(prepared.vertices) && prepared.vertices[first] == first) ++first;
  first = given_one(fitted.source_vertices, first);
  return Warning{
      "unused-vertices",
      formatted("{}: {} of {}{}{}); the surface leaves {} out", name, with_separators(count),
                counted(prepared.given_vertex_count, "vertex"),
                count == 1 ? " belongs to no face (" : " belong to no face (the first is ", first,
                count == 1 ? "it" : "them"),
      count, first};
}

// Whoever draws front faces alone shows nothing of such parts from outside, or their far sides.
std::optional<Warning> inside_out_warning(const FittedMesh& fitted, std::string_view name) {
  const UsedPart used = used_part(fitted.mesh, fitted.fit.prepared);
  const InsideOutParts found = inside_out_parts(used.mesh, *used.prepared->topology,
                                                statistics(*used.prepared).component_count);
  if (found.count == 0) return std::nullopt;
  const std::int64_t face = given_one(fitted.source_faces, found.first_face);
  return Warning{
      "inside-out",
      formatted("{}: closed parts whose faces look inward: {}, first at face {}; renderers that "
                "draw front faces alone show them from inside; turn the faces over where that is "
                "not meant",
                name, with_separators(found.count), face),
      found.count, face};
}

std::string convergence_remedy(const FittedMesh& fitted) {
  if (fitted.options.method == InterpolationMethod::Fair) return "raise --tolerance";
  switch (fitted.fit.interpolation.stop_reason) {
    case StopReason::Singular:
      return "this scheme has no surface through these vertices, as can be where three faces meet "
             "at every vertex; take --scheme doo-sabin, which always has one";
    case StopReason::Diverged:
      return "the iteration drives the error up on this mesh; take --scheme doo-sabin, whose error "
             "always falls";
    default:
      return "raise --max-iterations or --tolerance";
  }
}

// "; first at face 12 near (1, 2, 0.5), face 14 near (1, 2, 0.7)".
std::string places_text(const FittedMesh& fitted, const std::vector<FoldedPlace>& places) {
  std::string text;
  for (const FoldedPlace& place : places) {
    const glm::dvec3& p = place.position;
    text += formatted("{}{} near ({}, {}, {})", text.empty() ? "; first at face " : ", face ",
                      given_one(fitted.source_faces, place.face), short_number(p.x),
                      short_number(p.y), short_number(p.z));
  }
  return text;
}

std::string fold_remedy(const FittedMesh& fitted, bool only_the_input_is) {
  if (fitted.options.method == InterpolationMethod::Fair) {
    if (only_the_input_is) return "the input itself is folded there";
    return fitted.crease_degrees || fitted.finds_features
               ? "found creases do not help there, a finer or more even mesh may"
               : "the input is sharp there, --creases auto may help";
  }
  return fitted.options.scheme == Scheme::DooSabin
             ? "--interpolation fair is made for such meshes"
             : "--scheme doo-sabin --interpolation fair is made for such meshes";
}

}  // namespace

std::optional<Warning> torn_warning(const MeshToFit& ready, std::string_view name) {
  if (ready.weld || !ready.separated_edges.empty()) return std::nullopt;
  const UsedPart used = used_part(ready.mesh, ready.prepared);
  const TornVertices torn = torn_vertices(used.mesh, *used.prepared->topology);
  if (torn.count == 0) return std::nullopt;
  const std::int32_t first = used.vertices[static_cast<std::size_t>(torn.first)];
  return Warning{"torn-vertices", std::string(name) + ": " + torn_text(torn), torn.count,
                 given_one(ready.source_vertices, first)};
}

std::optional<Warning> convergence_warning(const FittedMesh& fitted, std::string_view name) {
  const Interpolation& result = fitted.fit.interpolation;
  if (result.converged) return std::nullopt;
  const bool iterates = fitted.options.method == InterpolationMethod::Progressive;
  const std::int64_t worst = result.worst_vertex;
  return Warning{
      "not-converged",
      formatted("{}: not converged ({}): the error is {}{}, the tolerance {}; what is written says "
                "so; {}",
                name, name_of(result.stop_reason), short_number(result.error.max),
                iterates ? " after " + counted(result.iterations, "iteration") : "",
                short_number(fitted.options.tolerance), convergence_remedy(fitted)),
      1, worst < 0 ? worst : given_one(fitted.source_vertices, worst)};
}

std::vector<Warning> mesh_warnings(const FittedMesh& fitted, std::string_view name, bool of_input) {
  std::vector<Warning> all;
  if (auto missed = convergence_warning(fitted, name)) all.push_back(*std::move(missed));
  if (auto unused = unused_warning(fitted, name)) all.push_back(*std::move(unused));
  if (!of_input) return all;
  if (auto inside_out = inside_out_warning(fitted, name)) all.push_back(*std::move(inside_out));
  return all;
}

std::optional<Warning> fold_warning(const FittedMesh& fitted, const SurfaceQuality& quality,
                                    bool against_source) {
  if (quality.folded_area <= kFoldedAreaLimit) return std::nullopt;
  const bool some_is_the_inputs = quality.folded_area_elsewhere < quality.folded_area;
  return Warning{
      "folded-area",
      formatted("{} of the surface is folded (turned by more than 90 degrees from {}){}{}; {}",
                percent(quality.folded_area), against_source ? "the source" : "its face",
                some_is_the_inputs
                    ? ", " + percent(quality.folded_area_elsewhere) + " where the input is not"
                    : "",
                places_text(fitted, quality.folded_places),
                fold_remedy(fitted, quality.folded_area_elsewhere <= kFoldedAreaLimit)),
      1,
      quality.folded_places.empty()
          ? -1
          : given_one(fitted.source_faces, quality.folded_places.front().face)};
}

std::optional<Warning> slide_warning(const FittedMesh& fitted, const TextureSlide& slide) {
  if (slide.largest_distance <= kTextureSlideLimit) return std::nullopt;
  const std::int64_t face = given_one(fitted.source_faces, slide.face);
  return Warning{
      "sliding-texture",
      formatted("the texture slides by up to {} of the diagonal on the surface, at face {}; {}",
                short_number(slide.largest_distance), face,
                fitted.options.scheme == Scheme::DooSabin
                    ? "more vertices there, or sharp edges where the surface should not be round, "
                      "keep it"
                    : "--scheme doo-sabin keeps it"),
      1, face};
}

std::optional<Warning> rounding_warning(std::string_view output, double error, double tolerance) {
  if (error <= tolerance) return std::nullopt;
  return Warning{"rounded-output",
                 formatted("{}: rounding for the file leaves an error of {}, above the tolerance "
                           "{}; --cage and .ply keep every digit",
                           output, short_number(error), short_number(tolerance))};
}

std::optional<Warning> size_warning(std::string_view output, std::uint64_t bytes,
                                    std::uint64_t input_bytes, int level) {
  constexpr std::uint64_t kLarge = 16u << 20, kManyTimes = 20;
  if (bytes <= kLarge || bytes <= kManyTimes * input_bytes) return std::nullopt;
  const double times = static_cast<double>(bytes) / static_cast<double>(input_bytes);
  return Warning{
      "large-output",
      formatted("{}: is {}, {} times the input; {}", output, byte_size(bytes),
                with_separators(static_cast<std::int64_t>(times)),
                level > 1 ? "--levels 1 writes about a quarter of that"
                          : "--levels 0 writes the input's own faces, with the surface's normals")};
}

namespace {

using Json = nlohmann::ordered_json;

Json norms_json(const ErrorNorms& norms) { return {{"max", norms.max}, {"rms", norms.rms}}; }

Json choice_json(const std::optional<Choice>& choice) {
  if (!choice) return nullptr;
  Json candidates = Json::array();
  for (std::size_t i = 0; i < choice->candidates.size(); ++i) {
    const Candidate& candidate = choice->candidates[i];
    const auto measured = [&](double figure) -> Json {
      return candidate.is_measured() ? Json(figure) : Json();
    };
    candidates.push_back({{"faces", word_of(kFacesWords, candidate.faces)},
                          {"method", word_of(kMethodWords, candidate.method)},
                          {"converged", candidate.converged},
                          {"folded_area_elsewhere", measured(candidate.folded_area)},
                          {"bending", measured(candidate.bending)},
                          {"cost", measured(candidate.cost())},
                          {"taken", i == choice->taken}});
  }
  const auto text = [](const std::string& reason) {
    return reason.empty() ? Json() : Json(reason);
  };
  return {{"reason", text(choice->reason)},
          {"faces_reason", text(choice->faces_reason)},
          {"candidates", candidates}};
}

Json fair_json(const FitFigures& fit) {
  if (!fit.fair) return nullptr;
  const FairFigures& fair = *fit.fair;
  return {{"polish", fit.polish_steps},
          {"shrunk_vertices", fair.shrunk_vertices},
          {"reversed_vertices", fair.reversed_vertices},
          {"cured_vertices", fair.cured_vertices},
          {"least_polygon", fair.least_polygon ? Json(*fair.least_polygon) : Json()},
          {"rounded_edges", fit.rounded_edges},
          {"flagged_edges", fair.flagged_edges},
          {"flagged_faces", fair.flagged_faces},
          {"rounds",
           {{"nets", fair.rounds.nets},
            {"repair", fair.rounds.repair ? Json(*fair.rounds.repair) : Json()},
            {"cure", fair.rounds.cure ? Json(*fair.rounds.cure) : Json()}}}};
}

Json bending_json(const std::optional<SurfaceQuality>& quality) {
  return quality ? Json(quality->bending) : Json();
}

Json within_json(const std::optional<WithinFit>& within) {
  if (!within) return nullptr;
  return {{"allowed", within->within},
          {"noise", within->noise ? Json(*within->noise) : Json()},
          {"distance", norms_json(within->distance)},
          {"at_bound", within->at_bound},
          {"bending_before", within->bending_before},
          {"bending_after", within->bending_after},
          {"surface_bending_before", bending_json(within->exact)},
          {"surface_bending_after", bending_json(within->left)}};
}

}  // namespace

Json input_json(const FitFigures& fit, const MeshStatistics& statistics, std::int64_t folded_edges,
                double folded_edge_area) {
  Json sizes = Json::object();
  for (std::size_t n = 0; n < statistics.face_size_counts.size(); ++n)
    if (statistics.face_size_counts[n] != 0)
      sizes[std::to_string(n)] = statistics.face_size_counts[n];
  return {{"vertices", statistics.vertex_count},
          {"faces", statistics.face_count},
          {"face_sizes", sizes},
          {"boundary_loops", statistics.boundary_loop_count},
          {"components", statistics.component_count},
          {"genus", statistics.genus},
          {"sharp_edges", fit.sharp_edges},
          {"corners", fit.corners},
          {"folded_edges", {{"count", folded_edges}, {"area", folded_edge_area}}},
          {"welded", fit.welded},
          {"separated_edges", fit.separated_edges},
          {"changed_faces", fit.changed_faces}};
}

Json solve_json(const FitFigures& fit) {
  const Interpolation& result = fit.interpolation;
  const bool iterates = fit.method == InterpolationMethod::Progressive;
  const auto where = [](bool applies, Json value) { return applies ? value : Json(); };
  Json json;
  json["method"] = word_of(kMethodWords, fit.method);
  json["choice"] = choice_json(fit.choice);
  json["scheme"] = word_of(kSchemeWords, fit.scheme);
  json["weights"] = where(fit.scheme == Scheme::DooSabin, word_of(kWeightsWords, fit.weights));
  json["solver"] = where(iterates, word_of(kSolverWords, fit.solver));
  json["boundary"] = word_of(kBoundaryWords, fit.boundary);
  json["creases"] = fit.creases;
  json["repair"] = fit.repairs ? "safe" : "none";
  json["weld"] = fit.weld ? Json(*fit.weld) : Json();
  json["quads"] = {{"joined", fit.joined}};
  json["refine"] = {{"added", fit.added}};
  json["tolerance"] = fit.tolerance;
  json["within"] = within_json(fit.within);
  json["converged"] = result.converged;
  json["stop_reason"] = name_of(result.stop_reason);
  json["iterations"] = result.iterations;
  json["spectral_bound"] = where(iterates, fit.spectral_bound);
  json["error"] = norms_json(result.error);
  json["error"]["worst_vertex"] = result.worst_vertex;
  json["history"] = Json::array();
  for (std::size_t i = 0; i < result.history.size(); ++i) {
    Json entry{{"iteration", i}};
    entry.update(norms_json(result.history[i]));
    json["history"].push_back(entry);
  }
  json["fair"] = fair_json(fit);
  return json;
}

Json quality_json(const SurfaceQuality& quality, int level) {
  return {{"level", level},
          {"reference", "input"},
          {"folded_area", quality.folded_area},
          {"folded_area_elsewhere", quality.folded_area_elsewhere},
          {"rms_normal_deviation", quality.rms_normal_deviation},
          {"max_normal_deviation", quality.max_normal_deviation},
          {"bending", quality.bending}};
}

Json warnings_json(std::span<const Warning> warnings) {
  Json json = Json::array();
  for (const Warning& warning : warnings) {
    json.push_back({{"code", warning.code},
                    {"message", warning.message},
                    {"count", warning.count},
                    {"first", warning.first}});
  }
  return json;
}

}  // namespace planish
