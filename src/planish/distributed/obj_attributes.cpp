#include "planish/distributed/obj_attributes.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/files/obj/obj_names.h"
#include "planish/files/shared/group_list.h"

namespace planish {

namespace {

// "=" and the name, or nothing.
std::array<std::string, 3> texts_of(const ObjNames& names) {
  const auto text = [](const std::optional<std::string>& name) {
    return name ? "=" + *name : std::string();
  };
  return {text(names.object), text(names.group), text(names.material)};
}

void take_texts(std::span<const std::string> texts, ObjNames& names) {
  std::optional<std::string>* const to[] = {&names.object, &names.group, &names.material};
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (!texts[i].empty()) *to[i] = texts[i].substr(1);
}

void settle_colors(const Ranks& ranks, std::vector<glm::vec4> colors, MeshSlice& slice) {
  SliceAttributes& to = slice.attributes;
  to.has_colors = max_over(ranks, std::int64_t{!colors.empty()}) > 0;
  if (!to.has_colors) return;
  to.colors = std::move(colors);
  to.colors.resize(slice.positions.size(), kNoObjColor);
  std::ranges::replace(to.colors, kNoObjColor, glm::vec4(1.0f));
}

void settle_uvs(const Ranks& ranks, ObjPart& part, MeshSlice& slice) {
  SliceAttributes& to = slice.attributes;
  to.uv_runs = layout_of(ranks, static_cast<std::int64_t>(part.uvs.size()));
  to.has_uvs = max_over(ranks, std::int64_t{!part.mesh.face_uvs.empty()}) > 0;
  // Coordinates that no corner names are dropped.
  if (!to.has_uvs) return;
  to.uvs = std::move(part.uvs);
  to.face_uvs.assign(part.mesh.face_uvs.begin(), part.mesh.face_uvs.end());
  to.face_uvs.resize(slice.face_vertices.size(), -1);
}

void settle_names(const Ranks& ranks, const std::vector<ObjPart::Naming>& namings,
                  MeshSlice& slice) {
  ObjNames own;
  for (const ObjPart::Naming& naming : namings) own.take(naming);
  const auto texts = texts_of(own);
  const std::vector<std::string> all = texts_of_all(ranks, texts);
  ObjNames names;
  for (int r = 0; r < ranks.rank; ++r)
    take_texts(std::span(all).subspan(static_cast<std::size_t>(r) * texts.size(), texts.size()),
               names);
  GroupList list;
  std::vector<std::int32_t> face_groups;
  const auto name_until = [&](std::int64_t face) {
    if (face > static_cast<std::int64_t>(face_groups.size()))
      face_groups.resize(static_cast<std::size_t>(face), list.index_of(names.face_group()));
  };
  for (const ObjPart::Naming& naming : namings) {
    name_until(naming.faces_before);
    names.take(naming);
  }
  name_until(slice.face_count());
  settle_groups(ranks, list.groups(), std::move(face_groups), slice.attributes);
}

}  // namespace

void settle_obj_attributes(const Ranks& ranks, ObjPart& part, MeshSlice& slice) {
  settle_colors(ranks, std::move(part.mesh.colors), slice);
  settle_uvs(ranks, part, slice);
  settle_names(ranks, part.namings, slice);
}

}  // namespace planish
