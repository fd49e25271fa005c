#include "planish/pipeline/make_ready.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/mesh/convex_faces.h"
#include "planish/mesh/cusp_corners.h"
#include "planish/mesh/flat_triangles.h"
#include "planish/mesh/mirrored_charts.h"
#include "planish/mesh/weld_vertices.h"

namespace planish {
namespace {

// Of triangles in a row on one line each round takes out one.
constexpr int kFlatRounds = 8;

// Takes a mesh with other faces: of which of its own they are, and which of these changed.
void take_faces(ReadyMesh& ready, PolygonMesh&& mesh, std::vector<std::int32_t>&& source_faces,
                std::vector<std::int32_t> changed_faces) {
  std::vector<std::int32_t>& sources = ready.source_faces;
  if (!sources.empty())
    for (auto* faces : {&source_faces, &changed_faces})
      for (std::int32_t& face : *faces) face = sources[face];
  std::vector<std::int32_t>& changed = ready.changed_faces;
  changed.insert(changed.end(), changed_faces.begin(), changed_faces.end());
  std::ranges::sort(changed);
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  sources = std::move(source_faces);
  ready.mesh = std::move(mesh);
  ready.prepared = prepare_if_sound(ready.mesh);
}

std::int32_t source_of(const ReadyMesh& ready, std::int32_t face) {
  return ready.source_faces.empty() ? face : ready.source_faces[face];
}

void cut_concave_faces(ReadyMesh& ready) {
  ConvexMesh convex = with_convex_faces(ready.mesh);
  if (convex.cut_faces.empty()) return;
  const std::int64_t count = std::ssize(convex.cut_faces);
  ready.changes.push_back({"concave-faces",
                           formatted("faces with corners that turn inward or lie unevenly, cut in "
                                     "parts for the fair surface: {}",
                                     count),
                           count, source_of(ready, convex.cut_faces.front())});
  take_faces(ready, std::move(convex.mesh), std::move(convex.source_faces), convex.cut_faces);
}

void take_out_flat_triangles(ReadyMesh& ready, bool adds_uvs) {
  std::int64_t count = 0;
  std::int32_t first = -1;
  for (int round = 0; ready.prepared && round < kFlatRounds; ++round) {
    UnflattenedMesh made = without_flat_triangles(ready.mesh, *ready.prepared->topology, adds_uvs);
    if (made.flat_faces.empty()) break;
    count += std::ssize(made.flat_faces);
    if (first < 0) first = source_of(ready, made.flat_faces.front());
    take_faces(ready, std::move(made.mesh), std::move(made.source_faces), made.changed_faces);
  }
  if (count > 0)
    ready.changes.push_back(
        {"flat-triangles",
         formatted("triangles whose corners lie on a line, given to the faces beside them: {}",
                   count),
         count, first});
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

}  // namespace

bool pair_up(ReadyMesh& ready, std::optional<double> crease_degrees,
             std::span<const std::uint8_t> may_join) {
  PairedMesh paired =
      with_paired_triangles(ready.mesh, *ready.prepared, pair_options(crease_degrees, may_join));
  if (paired.pair_count == 0) return false;
  ready.paired_count = paired.pair_count;
  take_faces(ready, std::move(paired.mesh), std::move(paired.source_faces), {});
  return true;
}

void make_fair(ReadyMesh& ready) {
  cut_concave_faces(ready);
  if (ready.prepared) ready.mesh = with_cusp_corners(ready.mesh);
}

PairOptions pair_options(std::optional<double> crease_degrees,
                         std::span<const std::uint8_t> may_join) {
  PairOptions options{.may_join = may_join};
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
  if (choice.repairs && choice.stands_alone) {
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
  // Ranks mend nothing, and what they make is what comes out without repair.
  if (choice.repairs && ready.prepared) cut_mirrored_charts(ready.mesh, ready.mesh.uvs);
  if (shortened) ready.changes.insert(ready.changes.begin(), *shortened);
  if (choice.repairs) take_out_flat_triangles(ready, choice.stands_alone);
  const bool searches = choice.found == nullptr && ready.prepared;
  if (choice.found != nullptr) {
    ready.found = *choice.found;
    add_tags(ready.mesh, ready.found);
  }
  if (choice.finds_features && searches)
    ready.found = add_features(ready.mesh, ready.prepared, {}, choice.features_done);
  if (choice.pairs_triangles && ready.prepared)
    pair_up(ready, choice.crease_degrees, choice.may_join);
  if (choice.repairs && choice.method == InterpolationMethod::Fair) make_fair(ready);
  // On the faces that the fair method has cut.
  if (choice.crease_degrees && searches)
    ready.found = add_features(ready.mesh, ready.prepared, {.every = choice.crease_degrees});
  return ready;
}

std::string creases_text(bool uses_tags, bool finds_features,
                         std::optional<double> crease_degrees) {
  if (finds_features) return "auto";
  if (crease_degrees) return "auto:" + shortest(*crease_degrees);
  return uses_tags ? "use" : "ignore";
}

}  // namespace planish
