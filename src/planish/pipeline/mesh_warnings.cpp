#include "planish/pipeline/mesh_warnings.h"

#include <string>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/mesh/inside_out.h"
#include "planish/mesh/statistics.h"
#include "planish/mesh/torn_vertices.h"

namespace planish {
namespace {

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

}  // namespace

std::optional<Warning> torn_warning(const FittedMesh& ready, std::string_view name) {
  if (ready.weld || !ready.separated_edges.empty()) return std::nullopt;
  const UsedPart used = used_part(ready.mesh, ready.options.prepared);
  const TornVertices torn = torn_vertices(used.mesh, *used.prepared->topology);
  if (torn.count == 0) return std::nullopt;
  const std::int32_t first = used.vertices[static_cast<std::size_t>(torn.first)];
  return Warning{"torn-vertices", std::string(name) + ": " + torn_text(torn), torn.count,
                 given_one(ready.source_vertices, first)};
}

std::vector<Warning> mesh_warnings(const FittedMesh& fitted, std::string_view name, bool of_input) {
  std::vector<Warning> all;
  if (auto unused = unused_warning(fitted, name)) all.push_back(*std::move(unused));
  if (!of_input) return all;
  if (auto inside_out = inside_out_warning(fitted, name)) all.push_back(*std::move(inside_out));
  return all;
}

}  // namespace planish
