#include "planish/distributed/part_attributes.h"

#include <algorithm>
#include <utility>

namespace planish {

std::vector<glm::vec4> colors_along_curve(const Ranks& ranks, SliceAttributes& attributes,
                                          const CurveOrder& order) {
  if (!attributes.has_colors) return {};
  struct Colored {
    std::int64_t number;
    glm::vec4 color;
  };
  RawVector<Colored> sent(attributes.colors.size());
  for (std::size_t v = 0; v < sent.size(); ++v)
    sent[v] = {order.number_of[v], attributes.colors[v]};
  attributes.colors = {};
  const auto received = route<Colored>(ranks, sent, [&](const Colored& colored, std::size_t) {
    return owner_of(order.layout, colored.number);
  });
  std::vector<glm::vec4> colors(received.size());
  for (const Colored& colored : received)
    colors[colored.number - order.layout[ranks.rank]] = colored.color;
  return colors;
}

void fetch_attributes(const Ranks& ranks, SliceAttributes& attributes, MeshPart& part) {
  PartAttributes& own = part.attributes;
  if (attributes.has_colors) {
    const auto colors = fetch<glm::vec4>(ranks, part.ghosts, part.layout,
                                         [&](std::int64_t place) { return own.colors[place]; });
    own.colors.insert(own.colors.end(), colors.begin(), colors.end());
  }
  if (attributes.has_uvs) {
    const auto uvs = fetch<glm::dvec2>(ranks, own.uv_ids, attributes.uv_runs,
                                       [&](std::int64_t place) { return attributes.uvs[place]; });
    own.uvs.assign(uvs.begin(), uvs.end());
    attributes.uvs = {};
  }
  own.groups = std::move(attributes.groups);
}

void add_attributes(const MeshPart& part, SubMesh& sub) {
  const PartAttributes& from = part.attributes;
  if (!from.colors.empty())
    for (const std::int32_t vertex : sub.vertices) sub.mesh.colors.push_back(from.colors[vertex]);
  if (!from.face_groups.empty()) {
    sub.mesh.groups = from.groups;
    for (const std::int32_t face : sub.faces)
      sub.mesh.face_groups.push_back(from.face_groups[face]);
  }
  if (from.face_uvs.empty()) return;
  std::vector<std::int32_t>& named = sub.mesh.face_uvs;
  for (const std::int32_t face : sub.faces)
    named.insert(named.end(), from.face_uvs.begin() + part.face_offsets[face],
                 from.face_uvs.begin() + part.face_offsets[face + 1]);
  std::vector<std::int32_t> used = named;
  std::ranges::sort(used);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  if (!used.empty() && used.front() < 0) used.erase(used.begin());
  for (const std::int32_t uv : used) sub.mesh.uvs.push_back(from.uvs[uv]);
  for (std::int32_t& uv : named)
    if (uv >= 0) uv = static_cast<std::int32_t>(std::ranges::lower_bound(used, uv) - used.begin());
}

}  // namespace planish
