#include "planish/distributed/obj_attributes.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "planish/core/error.h"
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

}  // namespace

void ObjAttributes::append(const ObjPart& part, const std::string& place, const MeshSlice& before) {
  const PolygonMesh& mesh = part.mesh;
  if (!mesh.colors.empty()) {
    colors_.resize(before.positions.size(), kNoObjColor);
    colors_.insert(colors_.end(), mesh.colors.begin(), mesh.colors.end());
  }
  if (!mesh.face_uvs.empty()) {
    const std::size_t first = before.face_vertices.size();
    face_uvs_.resize(first, -1);
    face_uvs_.insert(face_uvs_.end(), mesh.face_uvs.begin(), mesh.face_uvs.end());
    for (const std::size_t corner : part.backward_uvs) {
      face_uvs_[first + corner] += static_cast<std::int64_t>(uvs_.size());
      backward_.push_back(first + corner);
    }
  }
  uvs_.insert(uvs_.end(), part.uvs.begin(), part.uvs.end());
  for (const ObjPart::Naming& naming : part.namings) {
    namings_.push_back(naming);
    named_from_.push_back(before.face_count() + naming.faces_before);
  }
  clamped_colors_ += part.clamped_colors;
  if (part.largest_uv.index <= largest_uv_) return;
  largest_uv_ = part.largest_uv.index;
  largest_place_ = place + ":" + std::to_string(part.largest_uv.line);
}

void ObjAttributes::settle_colors(const Ranks& ranks, MeshSlice& slice) {
  SliceAttributes& to = slice.attributes;
  to.has_colors = max_over(ranks, std::int64_t{!colors_.empty()}) > 0;
  if (const std::int64_t count = sum_over(ranks, clamped_colors_); count > 0)
    slice.warnings.push_back(
        {.code = "clamped-colors",
         .message = std::to_string(count) + " vertex colours lie outside 0 to 1 and are clamped",
         .count = count});
  if (!to.has_colors) return;
  to.colors = std::move(colors_);
  to.colors.resize(slice.positions.size(), kNoObjColor);
  std::ranges::replace(to.colors, kNoObjColor, glm::vec4(1.0f));
}

void ObjAttributes::settle_uvs(const Ranks& ranks, const std::string& path, MeshSlice& slice) {
  SliceAttributes& to = slice.attributes;
  to.uv_runs = layout_of(ranks, static_cast<std::int64_t>(uvs_.size()));
  to.has_uvs = max_over(ranks, std::int64_t{!face_uvs_.empty()}) > 0;
  const std::int64_t total = to.uv_runs.back();
  agree(ranks, [&] {
    const auto fail = [](const std::string& what) {
      throw Error(ErrorCode::UnreadableInput, what);
    };
    // Readers of parts count in 32 bits.
    if (total >= std::numeric_limits<std::int32_t>::max())
      fail(path + ": " + std::to_string(total) +
           " texture coordinates, and 2147483646 can be read; " + "leave them out");
    for (const std::size_t corner : backward_) {
      face_uvs_[corner] += to.uv_runs[ranks.rank];
      if (face_uvs_[corner] < 0)
        fail(path + ": a face counts back behind the first texture coordinate");
    }
    if (largest_uv_ >= total)
      fail(largest_place_ + ": face names texture coordinate " + std::to_string(largest_uv_ + 1) +
           " of " + std::to_string(total));
  });
  // Coordinates that no corner names are dropped.
  if (!to.has_uvs) return;
  to.uvs = std::move(uvs_);
  to.face_uvs = std::move(face_uvs_);
  to.face_uvs.resize(slice.face_vertices.size(), -1);
}

void ObjAttributes::settle_names(const Ranks& ranks, MeshSlice& slice) {
  ObjNames own;
  for (const ObjPart::Naming& naming : namings_) own.take(naming);
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
  for (std::size_t i = 0; i < namings_.size(); ++i) {
    name_until(named_from_[i]);
    names.take(namings_[i]);
  }
  name_until(slice.face_count());
  settle_groups(ranks, list.groups(), std::move(face_groups), slice.attributes);
}

void ObjAttributes::settle(const Ranks& ranks, const std::string& path, MeshSlice& slice) {
  settle_colors(ranks, slice);
  settle_uvs(ranks, path, slice);
  settle_names(ranks, slice);
}

}  // namespace planish
