#include "planish/distributed/slice_attributes.h"

#include <utility>

#include "planish/files/shared/group_list.h"

namespace planish {

namespace {

// From rank 0; `counts` are its own.
template <class T>
std::vector<T> scattered(const Ranks& ranks, std::span<const T> values,
                         std::span<const std::int64_t> counts) {
  const std::vector<std::int64_t> none(static_cast<std::size_t>(ranks.size), 0);
  const auto own =
      ranks.rank == 0 ? all_to_all<T>(ranks, values, counts) : all_to_all<T>(ranks, {}, none);
  return {own.begin(), own.end()};
}

}  // namespace

std::vector<std::string> texts_of_all(const Ranks& ranks, std::span<const std::string> own) {
  std::vector<std::int64_t> own_sizes;
  std::string own_letters;
  for (const std::string& text : own) {
    own_sizes.push_back(static_cast<std::int64_t>(text.size()));
    own_letters += text;
  }
  const auto sizes = all_gather<std::int64_t>(ranks, own_sizes);
  const auto letters = all_gather<char>(ranks, own_letters);
  std::vector<std::string> texts;
  std::size_t at = 0;
  for (const std::int64_t size : sizes) {
    texts.emplace_back(letters.data() + at, static_cast<std::size_t>(size));
    at += static_cast<std::size_t>(size);
  }
  return texts;
}

void settle_groups(const Ranks& ranks, std::span<const FaceGroup> own,
                   std::vector<std::int32_t> face_groups, SliceAttributes& attributes) {
  std::vector<std::string> names;
  for (const FaceGroup& group : own) {
    names.push_back(group.name);
    names.push_back(group.material);
  }
  const std::vector<std::string> all = texts_of_all(ranks, names);
  GroupList list;
  bool any_named = false;
  for (std::size_t i = 0; i < all.size(); i += 2) {
    any_named |= !all[i].empty() || !all[i + 1].empty();
    list.index_of({.name = all[i], .material = all[i + 1]});
  }
  attributes.has_groups = any_named;
  if (!any_named) return;
  for (std::int32_t& group : face_groups) group = list.index_of(own[group]);
  attributes.groups = list.take();
  attributes.face_groups = std::move(face_groups);
}

SliceAttributes scatter_attributes(const Ranks& ranks, const PolygonMesh& mesh,
                                   const ScatterCounts& counts) {
  SliceAttributes attributes;
  std::int64_t known[4] = {!mesh.colors.empty(), !mesh.face_uvs.empty(), !mesh.face_groups.empty(),
                           static_cast<std::int64_t>(mesh.uvs.size())};
  MPI_Bcast(known, 4, MPI_INT64_T, 0, ranks.comm);
  attributes.has_colors = known[0] != 0;
  attributes.has_uvs = known[1] != 0;
  attributes.has_groups = known[2] != 0;
  if (attributes.has_colors)
    attributes.colors = scattered<glm::vec4>(ranks, mesh.colors, counts.vertices);
  if (attributes.has_uvs) {
    attributes.uv_runs = even_layout(known[3], ranks.size);
    std::vector<std::int64_t> uv_counts;
    uv_counts.reserve(static_cast<std::size_t>(ranks.size));
    for (int r = 0; r < ranks.size; ++r)
      uv_counts.push_back(attributes.uv_runs[r + 1] - attributes.uv_runs[r]);
    attributes.uvs = scattered<glm::dvec2>(ranks, mesh.uvs, uv_counts);
    const std::vector<std::int32_t> named =
        scattered<std::int32_t>(ranks, mesh.face_uvs, counts.corners);
    attributes.face_uvs.assign(named.begin(), named.end());
  }
  if (!attributes.has_groups) return attributes;
  std::vector<std::string> names;
  if (ranks.rank == 0) {
    for (const FaceGroup& group : mesh.groups) {
      names.push_back(group.name);
      names.push_back(group.material);
    }
  }
  const std::vector<std::string> all = texts_of_all(ranks, names);
  for (std::size_t i = 0; i < all.size(); i += 2)
    attributes.groups.push_back({.name = all[i], .material = all[i + 1]});
  attributes.face_groups = scattered<std::int32_t>(ranks, mesh.face_groups, counts.faces);
  return attributes;
}

}  // namespace planish
