#include "planish/pipeline/fit_report.h"

#include <string>

#include "planish/core/json.h"
#include "planish/pipeline/option_words.h"

namespace planish {
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
