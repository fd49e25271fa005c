// Parts of the file are read on all threads, then joined.
#include "planish/files/obj/read_obj.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "planish/files/obj/obj_names.h"
#include "planish/files/obj/obj_normals.h"
#include "planish/files/obj/obj_parts.h"
#include "planish/files/shared/attribute_collector.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/split_normals.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

// Groups hold until the next, across parts.
void name_faces(const ObjPart& part, PolygonMesh& mesh) {
  AttributeCollector attributes;
  ObjNames names;
  std::int64_t named = 0;
  const auto add_faces_to = [&](std::int64_t face) {
    attributes.add_faces(static_cast<std::size_t>(face - named));
    named = face;
  };
  for (const ObjPart::Naming& naming : part.namings) {
    add_faces_to(naming.faces_before);
    names.take(naming);
    attributes.use_group(names.face_group());
  }
  add_faces_to(part.mesh.face_count());
  PolygonMesh found;
  attributes.finish({}, found);
  mesh.groups = std::move(found.groups);
  mesh.face_groups = std::move(found.face_groups);
}

// Corners that name coordinates which are not there, or are no numbers, have none.
void drop_missing_uvs(ObjPart& part) {
  LineNote& missing = part.notes.missing_uvs;
  if (missing.count == 0 && part.notes.bad_uvs.count == 0) return;
  const bool is_beyond = part.largest_uv.index >= std::ssize(part.uvs);
  std::int64_t beyond = 0;
  for (std::int32_t& uv : part.mesh.face_uvs) {
    if (uv >= std::ssize(part.uvs)) {
      uv = -1;
      ++beyond;
    } else if (uv >= 0 && std::isnan(part.uvs[uv].x)) {
      uv = -1;
    }
  }
  if (is_beyond) missing.count += beyond - 1;
  for (glm::dvec2& uv : part.uvs)
    if (std::isnan(uv.x)) uv = glm::dvec2(0.0);
  const bool any = std::ranges::any_of(part.mesh.face_uvs, [](std::int32_t uv) { return uv >= 0; });
  if (!any) part.mesh.face_uvs = {};
}

// A vertex that no face names may be anywhere: without a place it is put at 0. Otherwise the note
// stays, and the file is refused.
void place_unused(ObjPart& part, std::string_view name, std::vector<Warning>& warnings) {
  LineNote& bad = part.notes.bad_positions;
  std::vector<glm::dvec3>& positions = part.mesh.positions;
  const auto is_bad = [](const glm::dvec3& p) { return !std::isfinite(p.x + p.y + p.z); };
  const bool is_used = std::ranges::any_of(part.mesh.face_vertices, [&](std::int32_t vertex) {
    return vertex < std::ssize(positions) && is_bad(positions[vertex]);
  });
  if (bad.count == 0 || is_used || part.mesh.face_vertices.empty()) return;
  std::ranges::replace_if(positions, is_bad, glm::dvec3(0.0));
  bad.warn(warnings, "missing-positions", name, "no face names such vertices, which are put at 0");
  bad = {};
}

MeshFile read_lines(const FileBytes& file, std::size_t part_bytes) {
  const TextLines whole(file, TextLines::Continuation::Backslash);
  const std::vector<TextLines> lines = whole.cut(part_bytes);
  ObjParts parts(
      lines.size(), [&](std::size_t p, const auto& use) { use(lines[p]); }, /*is_start=*/true);
  ObjPart all = parts.join({});
  MeshFile found{.format = FileFormat::Obj};
  place_unused(all, file.name, found.warnings);
  require_obj(all, all.counts(), whole);
  drop_missing_uvs(all);
  warn_of(all, file.name, found.warnings);
  name_faces(all, all.mesh);
  found.header = std::move(all.header);
  found.dropped_element_count = all.dropped_element_count;
  // Coordinates that no corner names are dropped.
  if (!all.mesh.face_uvs.empty()) all.mesh.uvs = std::move(all.uvs);
  std::ranges::replace(all.mesh.colors, kNoObjColor, glm::vec4(1.0f));
  found.mesh = std::move(all.mesh);
  return found;
}

}  // namespace

MeshFile read_obj(const FileBytes& file, std::size_t part_bytes) {
  if (file.split_normals_crease) expect_passes(file, 2);
  MeshFile found = read_lines(file, part_bytes);
  const bool is_cloud = found.mesh.face_count() == 0 && !found.mesh.positions.empty();
  if (!is_cloud && !file.split_normals_crease) return found;
  LineNote missing;
  CornerNormals normals = read_obj_normals(file, missing);
  missing.warn(found.warnings, "missing-normals", file.name, "such corners have none");
  if (is_cloud) {
    if (normals.values.size() == found.mesh.positions.size())
      found.normals = std::move(normals.values);
    return found;
  }
  weld_repeated_vertices(found);
  mark_split_normals(found.mesh, normals);
  return found;
}

}  // namespace planish
