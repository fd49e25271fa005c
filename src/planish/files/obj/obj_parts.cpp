#include "planish/files/obj/obj_parts.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

ObjCounts operator+(const ObjCounts& a, const ObjCounts& b) {
  return {a.line + b.line, a.vertex + b.vertex, a.uv + b.uv, a.face + b.face, a.corner + b.corner};
}

bool is_too_large(const ObjCounts& counts) {
  return std::max({counts.vertex, counts.uv, counts.corner}) >
         std::numeric_limits<std::int32_t>::max();
}

constexpr const char* kNamesUv = "face names texture coordinate ";

std::string fault_of(const LargestIndex& largest, int base, const char* what, std::int64_t count) {
  return formatted("{}{} of {}", what, largest.index + base, count);
}

void require(const LargestIndex& largest, int base, const char* what, std::int64_t count,
             const TextLines& lines) {
  if (largest.index >= count)
    lines.fail_at(largest.line, fault_of(largest, base, what, count), largest.element);
}

}  // namespace

ObjParts::ObjParts(std::size_t count, LinesOf lines_of, bool is_start)
    : lines_of_(std::move(lines_of)), parts_(count) {
  const ObjCounts none;
  parallel_each(count, 1, [&](std::size_t p) {
    const ObjCounts* before = p == 0 && is_start ? &none : nullptr;
    failure_.watch(p, [&] {
      lines_of_(p, [&](const TextLines& lines) {
        parts_[p] = read_obj_part(lines, before);
        lines.count();
      });
    });
  });
}

ObjCounts ObjParts::counts() const {
  ObjCounts all;
  for (std::size_t p = 0; p < std::min(parts_.size(), failure_.part()); ++p)
    all = all + parts_[p].counts();
  return all;
}

void ObjParts::read_again(std::size_t part, const ObjCounts& before) {
  lines_of_(part, [&](const TextLines& lines) { parts_[part] = read_obj_part(lines, &before); });
}

ObjPart ObjParts::join(const ObjCounts& before) {
  std::vector<ObjCounts> bases{before};
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const ObjPart& part = parts_[p];
    if (p == failure_.part() || part.backward_vertices.lowest < -bases[p].vertex ||
        part.backward_uvs.lowest < -bases[p].uv || is_too_large(bases[p] + part.counts()))
      read_again(p, bases[p]);
    bases.push_back(bases[p] + parts_[p].counts());
  }
  settle(bases);
  ObjPart all;
  gather_notes(bases, all);
  gather(bases, all);
  return all;
}

void ObjParts::settle(const std::vector<ObjCounts>& before) {
  parallel_each(parts_.size(), 1, [&](std::size_t p) {
    PolygonMesh& mesh = parts_[p].mesh;
    for (const std::size_t corner : parts_[p].backward_vertices.corners)
      mesh.face_vertices[corner] += static_cast<std::int32_t>(before[p].vertex);
    for (const std::size_t corner : parts_[p].backward_uvs.corners)
      mesh.face_uvs[corner] += static_cast<std::int32_t>(before[p].uv);
    for (std::int32_t& offset : mesh.face_offsets)
      offset += static_cast<std::int32_t>(before[p].corner - before[0].corner);
    for (ObjPart::Naming& naming : parts_[p].namings)
      naming.faces_before += before[p].face - before[0].face;
  });
}

void ObjParts::gather_notes(const std::vector<ObjCounts>& before, ObjPart& all) const {
  const auto append = [](auto& to, const auto& values) {
    to.insert(to.end(), values.begin(), values.end());
  };
  PolygonMesh& mesh = all.mesh;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const ObjPart& part = parts_[p];
    const ObjCounts base = part.is_settled ? ObjCounts() : before[p];
    append(all.header, part.header);
    append(all.namings, part.namings);
    append(mesh.creases, part.mesh.creases);
    append(mesh.corners, part.mesh.corners);
    append(mesh.hole_faces, part.mesh.hole_faces);
    all.dropped_element_count += part.dropped_element_count;
    all.line_count += part.line_count;
    all.largest_vertex.join(part.largest_vertex, base.line, base.face);
    all.largest_uv.join(part.largest_uv, base.line, base.face);
    all.tags.largest_vertex.join(part.tags.largest_vertex, base.line, 0);
    all.tags.largest_face.join(part.tags.largest_face, base.line, 0);
    all.tags.unknown.join(part.tags.unknown, base.line, 0);
    all.notes.unknown_keyword.join(part.notes.unknown_keyword, base.line, 0);
    all.notes.bad_colors.join(part.notes.bad_colors, base.line, base.vertex);
    all.notes.bad_uvs.join(part.notes.bad_uvs, base.line, base.uv);
    all.notes.missing_uvs.join(part.notes.missing_uvs, base.line, base.face);
    all.notes.continued_names.join(part.notes.continued_names, base.line, 0);
    all.notes.bad_positions.join(part.notes.bad_positions, base.line, base.vertex);
    all.notes.clamped_colors += part.notes.clamped_colors;
  }
}

// The values themselves, each kind by a thread.
void ObjParts::gather(const std::vector<ObjCounts>& before, ObjPart& all) {
  PolygonMesh& mesh = all.mesh;
  const auto total = [&](std::int64_t ObjCounts::*count) {
    return static_cast<std::size_t>(before.back().*count - before.front().*count);
  };
  const auto append = [&](auto& to, auto& values, std::size_t size) {
    if (to.empty()) {
      to = std::move(values);
    } else {
      to.reserve(size);  // here, where GCC 14 sees that insert() has room
      to.insert(to.end(), values.begin(), values.end());
    }
    values = {};
  };
  const auto join_all = [&](auto& to, const auto& values_of, std::int64_t ObjCounts::*count) {
    for (ObjPart& part : parts_) append(to, values_of(part), total(count));
  };
  // What a part has fewer of than its vertices or corners is filled up.
  const auto join_filled = [&](auto& to, auto member, const auto& filler,
                               std::int64_t ObjCounts::*count) {
    const bool any =
        std::ranges::any_of(parts_, [&](ObjPart& part) { return !(part.mesh.*member).empty(); });
    if (!any) return;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      append(to, parts_[p].mesh.*member, total(count));
      to.resize(static_cast<std::size_t>(before[p + 1].*count - before.front().*count), filler);
    }
  };
  const std::array<std::function<void()>, 6> tasks = {
      [&] {
        join_all(
            mesh.positions, [](ObjPart & p) -> auto& { return p.mesh.positions; },
            &ObjCounts::vertex);
      },
      [&] {
        join_all(
            mesh.face_vertices, [](ObjPart & p) -> auto& { return p.mesh.face_vertices; },
            &ObjCounts::corner);
      },
      [&] {
        mesh.face_offsets = std::move(parts_.front().mesh.face_offsets);
        mesh.face_offsets.reserve(total(&ObjCounts::face) + 1);
        for (std::size_t p = 1; p < parts_.size(); ++p) {
          const std::vector<std::int32_t>& offsets = parts_[p].mesh.face_offsets;
          mesh.face_offsets.insert(mesh.face_offsets.end(), offsets.begin() + 1, offsets.end());
        }
      },
      [&] { join_filled(mesh.face_uvs, &PolygonMesh::face_uvs, -1, &ObjCounts::corner); },
      [&] { join_filled(mesh.colors, &PolygonMesh::colors, kNoObjColor, &ObjCounts::vertex); },
      [&] {
        join_all(
            all.uvs, [](ObjPart & p) -> auto& { return p.uvs; }, &ObjCounts::uv);
      }};
  parallel_each(tasks.size(), 1, [&](std::size_t i) { tasks[i](); });
}

void require_obj(ObjPart& part, const ObjCounts& all, const TextLines& lines) {
  for (const LineNote* unknown : {&part.notes.unknown_keyword, &part.tags.unknown})
    if (unknown->count > 0 && all.vertex == 0)
      lines.fail_at(unknown->line,
                    unknown->what + " in a file without vertices: this is no OBJ file");
  if (const LineNote& bad = part.notes.bad_positions; bad.count > 0)
    lines.fail_at(bad.line, bad.what, bad.element);
  // Faces count from 1, tags from 0.
  require(part.largest_vertex, 1, "face names vertex ", all.vertex, lines);
  if (const LargestIndex& uv = part.largest_uv; uv.index >= all.uv)
    lines.note_at(part.notes.missing_uvs, uv.line, fault_of(uv, 1, kNamesUv, all.uv), uv.element);
  require(part.tags.largest_vertex, 0, "tag names vertex ", all.vertex, lines);
  require(part.tags.largest_face, 0, "tag names face ", all.face, lines);
}

void warn_of(const ObjPart& part, std::string_view name, std::vector<Warning>& warnings) {
  const auto warn_of_unknown = [&](const char* code, const LineNote& unknown) {
    if (unknown.count > 0)
      warnings.push_back(
          {.code = code,
           .message = formatted("line {}: {}; such lines are ignored", unknown.line, unknown.what),
           .count = unknown.count});
  };
  warn_of_unknown("unknown-keyword", part.notes.unknown_keyword);
  warn_of_unknown("unknown-tag", part.tags.unknown);
  if (const std::int64_t count = part.notes.clamped_colors; count > 0)
    warnings.push_back({.code = "clamped-colors",
                        .message = counted(count, "vertex colour") +
                                   (count == 1 ? " lies outside 0 to 1 and is clamped"
                                               : " lie outside 0 to 1 and are clamped"),
                        .count = count});
  part.notes.bad_colors.warn(warnings, "missing-colors", name, "such vertices have no colour");
  part.notes.continued_names.warn(warnings, "continued-names", name,
                                  "a name without `\\` at its end keeps them apart");
  part.notes.bad_uvs.warn(warnings, "missing-texture-coordinates", name,
                          "corners that name such have none");
  part.notes.missing_uvs.warn(warnings, "missing-texture-coordinates", name,
                              "such corners have none");
}

}  // namespace planish
