#include "planish/pipeline/make_ready.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/mesh/convex_faces.h"
#include "planish/mesh/cusp_corners.h"
#include "planish/mesh/weld_vertices.h"

namespace planish {
namespace {

void cut_concave_faces(ReadyMesh& prepared) {
  ConvexMesh convex = with_convex_faces(prepared.mesh);
  if (convex.cut_faces.empty()) return;
  std::vector<std::int32_t>& sources = prepared.source_faces;
  const auto source_of = [&](std::int32_t face) { return sources.empty() ? face : sources[face]; };
  const auto count = static_cast<std::int64_t>(convex.cut_faces.size());
  std::ranges::transform(convex.cut_faces, convex.cut_faces.begin(), source_of);
  prepared.changes.push_back({"concave-faces",
                              formatted("faces with corners that turn inward or lie unevenly, cut "
                                        "in parts for the fair surface: {}",
                                        count),
                              count, convex.cut_faces.front()});
  std::vector<std::int32_t>& changed = prepared.changed_faces;
  changed.insert(changed.end(), convex.cut_faces.begin(), convex.cut_faces.end());
  std::ranges::sort(changed);
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  std::ranges::transform(convex.source_faces, convex.source_faces.begin(), source_of);
  sources = std::move(convex.source_faces);
  prepared.mesh = std::move(convex.mesh);
  prepared.prepared = prepare_if_sound(prepared.mesh);
}

// Of a mesh that may have been welded already: of which vertices of the file its own are.
PolygonMesh take_welded(WeldedMesh&& welded, std::vector<std::int32_t>& sources,
                        std::int64_t& count) {
  count += welded.welded_count;
  if (!sources.empty() && welded.welded_count > 0)
    for (std::int32_t& source : welded.source_vertices) source = sources[source];
  if (welded.welded_count > 0) sources = std::move(welded.source_vertices);
  return std::move(welded.mesh);
}

// What was said of the vertices of the welded mesh, of the file's.
void name_sources(ReadyMesh& ready, std::vector<std::int32_t>&& welded) {
  if (welded.empty()) return;
  for (auto& [a, b] : ready.separated_edges) std::tie(a, b) = std::minmax(welded[a], welded[b]);
  std::ranges::sort(ready.separated_edges);
  for (Warning& change : ready.changes) {
    const bool is_vertex = change.code.starts_with("non-manifold");
    if (is_vertex && change.first >= 0) change.first = welded[change.first];
  }
  if (ready.source_vertices.empty()) {
    ready.source_vertices = std::move(welded);
  } else {
    for (std::int32_t& source : ready.source_vertices) source = welded[source];
  }
}

void find_creases(ReadyMesh& ready, const Preparation& choice) {
  const CreaseDetectionOptions options = crease_detection(*choice.crease_degrees);
  FoundCreases found = add_found_creases(ready.mesh, *ready.prepared, options);
  if (!choice.smoothed_vertices.empty())
    leave_smooth(ready.mesh, *ready.prepared, found, choice.smoothed_vertices);
  if (choice.method == InterpolationMethod::Fair) ready.found = std::move(found);
}

}  // namespace

bool pair_up(ReadyMesh& ready, std::optional<double> crease_degrees) {
  PairedMesh paired =
      with_paired_triangles(ready.mesh, *ready.prepared, pair_options(crease_degrees));
  if (paired.pair_count == 0) return false;
  std::vector<std::int32_t>& sources = ready.source_faces;
  if (!sources.empty())
    for (std::int32_t& face : paired.source_faces) face = sources[face];
  sources = std::move(paired.source_faces);
  ready.paired_count = paired.pair_count;
  ready.mesh = std::move(paired.mesh);
  ready.prepared = prepare_if_sound(ready.mesh);
  return true;
}

void make_fair(ReadyMesh& ready) {
  cut_concave_faces(ready);
  if (ready.prepared) ready.mesh = with_cusp_corners(ready.mesh);
}

PairOptions pair_options(std::optional<double> crease_degrees) {
  PairOptions options;
  if (crease_degrees) options.largest_turn = std::min(options.largest_turn, *crease_degrees);
  return options;
}

ReadyMesh make_ready(PolygonMesh&& mesh, const Preparation& choice) {
  ReadyMesh ready;
  if (!choice.uses_tags) {
    mesh.creases.clear();
    mesh.corners.clear();
  }
  std::vector<std::int32_t> welded_sources;
  if (choice.weld)
    mesh = take_welded(weld_vertices(std::move(mesh), *choice.weld), welded_sources,
                       ready.welded_count);
  std::optional<Warning> shortened;
  if (choice.repairs && choice.welds_short_edges) {
    WeldedMesh welded = weld_short_edges(std::move(mesh));
    if (const std::int64_t count = welded.welded_count; count > 0) {
      const std::int32_t first = welded.first_welded;
      shortened = {
          "short-edges",
          formatted("vertices that coincide with a neighbour, made one with it: {}", count), count,
          welded_sources.empty() ? first : welded_sources[first]};
    }
    mesh = take_welded(std::move(welded), welded_sources, ready.welded_count);
  }
  ready.prepared = prepare_if_sound(mesh);
  if (ready.prepared || !choice.repairs) {
    ready.mesh = std::move(mesh);
  } else {
    static_cast<RepairedMesh&>(ready) = repair(mesh);
    ready.prepared = prepare_if_sound(ready.mesh);
  }
  name_sources(ready, std::move(welded_sources));
  if (shortened) ready.changes.insert(ready.changes.begin(), *shortened);
  if (choice.pairs_triangles && ready.prepared) pair_up(ready, choice.crease_degrees);
  if (choice.repairs && choice.method == InterpolationMethod::Fair) make_fair(ready);
  if (choice.crease_degrees && ready.prepared) find_creases(ready, choice);
  return ready;
}

std::string creases_text(bool uses_tags, std::optional<double> crease_degrees) {
  if (crease_degrees) return "auto:" + shortest(*crease_degrees);
  return uses_tags ? "use" : "ignore";
}

}  // namespace planish
