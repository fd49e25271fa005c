#include "planish/distributed/mesh_part.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/distributed/part_attributes.h"

namespace planish {

namespace {

constexpr std::size_t kMostLocal = std::numeric_limits<std::int32_t>::max() - 1;

struct StreamFace {
  std::int64_t id;
  const std::int64_t* corners;
  std::int64_t size;
};

// Ascending by id, each once.
RawVector<StreamFace> faces_of(const FaceForm& form,
                               std::initializer_list<std::span<const std::int64_t>> streams) {
  RawVector<StreamFace> faces;
  for (const std::span<const std::int64_t> stream : streams)
    for (std::size_t k = 0; k < stream.size();
         k += static_cast<std::size_t>(form.length(stream[k + 1])))
      faces.push_back({stream[k], stream.data() + k + 2, stream[k + 1]});
  oneapi::tbb::parallel_sort(faces.begin(), faces.end(),
                             [](const StreamFace& a, const StreamFace& b) { return a.id < b.id; });
  const auto same = [](const StreamFace& a, const StreamFace& b) { return a.id == b.id; };
  faces.erase(std::unique(faces.begin(), faces.end(), same), faces.end());
  return faces;
}

bool is_owned(const CurveOrder& order, int rank, std::int64_t number) {
  return number >= order.layout[rank] && number < order.layout[rank + 1];
}

std::vector<std::int64_t> ghosts_of(const RawVector<StreamFace>& faces, const CurveOrder& order,
                                    int rank) {
  std::vector<std::int64_t> ghosts;
  for (const StreamFace& face : faces)
    for (std::int64_t k = 0; k < face.size; ++k)
      if (!is_owned(order, rank, face.corners[k])) ghosts.push_back(face.corners[k]);
  std::ranges::sort(ghosts);
  ghosts.erase(std::unique(ghosts.begin(), ghosts.end()), ghosts.end());
  return ghosts;
}

// The faces around each owned vertex, as places in `faces`.
struct Around {
  std::vector<std::size_t> first;
  RawVector<std::size_t> faces;
};

Around around_owned(const RawVector<StreamFace>& faces, const CurveOrder& order, int rank) {
  Around around;
  const std::int64_t begin = order.layout[rank], end = order.layout[rank + 1];
  around.first.assign(static_cast<std::size_t>(end - begin) + 1, 0);
  const auto for_owned = [&](const auto& take) {
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (std::int64_t k = 0; k < faces[f].size; ++k)
        if (is_owned(order, rank, faces[f].corners[k]))
          take(f, static_cast<std::size_t>(faces[f].corners[k] - begin));
  };
  for_owned([&](std::size_t, std::size_t v) { ++around.first[v + 1]; });
  std::partial_sum(around.first.begin(), around.first.end(), around.first.begin());
  around.faces.resize(around.first.back());
  std::vector<std::size_t> place(around.first.begin(), around.first.end() - 1);
  for_owned([&](std::size_t f, std::size_t v) { around.faces[place[v]++] = f; });
  return around;
}

// The faces around other ranks' vertices that faces here name.
FaceStream fetch_second_ring(const Ranks& ranks, const FaceForm& form,
                             const RawVector<StreamFace>& faces, const CurveOrder& order) {
  if (ranks.size == 1) return {};
  const std::vector<std::int64_t> ghosts = ghosts_of(faces, order, ranks.rank);
  std::vector<std::int64_t> asked(ranks.size, 0), counts(ranks.size, 0), asking;
  for (const std::int64_t ghost : ghosts) ++asked[owner_of(order.layout, ghost)];
  const auto wanted = all_to_all<std::int64_t>(ranks, ghosts, asked, &asking);
  const Around around = around_owned(faces, order, ranks.rank);
  FaceStream reply;
  std::vector<std::int32_t> sent_to(faces.size(), -1);  // the last rank that got the face
  std::size_t at = 0;
  for (int r = 0; r < ranks.size; ++r) {
    const std::size_t before = reply.size();
    for (std::int64_t k = 0; k < asking[r]; ++k, ++at) {
      const auto v = static_cast<std::size_t>(wanted[at] - order.layout[ranks.rank]);
      for (std::size_t i = around.first[v]; i < around.first[v + 1]; ++i) {
        const std::size_t f = around.faces[i];
        if (std::exchange(sent_to[f], r) == r) continue;
        const std::int64_t* face = faces[f].corners - 2;
        reply.insert(reply.end(), face, face + form.length(faces[f].size));
      }
    }
    counts[r] = static_cast<std::int64_t>(reply.size() - before);
  }
  return all_to_all<std::int64_t>(ranks, reply, counts);
}

void require_fits(std::size_t count, const char* what) {
  if (count <= kMostLocal) return;
  throw Error(ErrorCode::OutOfMemory,
              formatted("a rank's part has {} {}, at most {} are possible; take more ranks", count,
                        what, kMostLocal));
}

void take_faces(const RawVector<StreamFace>& faces, MeshPart& part) {
  std::size_t corners = 0;
  for (const StreamFace& face : faces) corners += static_cast<std::size_t>(face.size);
  require_fits(corners, "corners of faces");
  require_fits(part.ghosts.size() + static_cast<std::size_t>(part.owned_count()), "vertices");
  part.face_ids.reserve(faces.size());
  part.face_offsets.reserve(faces.size() + 1);
  part.face_vertices.reserve(corners);
  for (const StreamFace& face : faces) {
    part.face_ids.push_back(face.id);
    for (std::int64_t k = 0; k < face.size; ++k)
      part.face_vertices.push_back(part.local_of(face.corners[k]));
    part.face_offsets.push_back(static_cast<std::int32_t>(part.face_vertices.size()));
  }
}

// Texture coordinates by their places among those here.
void take_face_attributes(const FaceForm& form, const RawVector<StreamFace>& faces,
                          PartAttributes& attributes) {
  if (form.has_groups) {
    attributes.face_groups.reserve(faces.size());
    for (const StreamFace& face : faces)
      attributes.face_groups.push_back(
          static_cast<std::int32_t>(face.corners[form.length(face.size) - 3]));
  }
  if (!form.has_uvs) return;
  RawVector<std::int64_t> named;
  for (const StreamFace& face : faces)
    named.insert(named.end(), face.corners + face.size, face.corners + 2 * face.size);
  std::vector<std::int64_t>& ids = attributes.uv_ids;
  ids.assign(named.begin(), named.end());
  oneapi::tbb::parallel_sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  if (!ids.empty() && ids.front() < 0) ids.erase(ids.begin());
  attributes.face_uvs.resize(named.size());
  parallel_for(named.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      attributes.face_uvs[c] =
          named[c] < 0
              ? -1
              : static_cast<std::int32_t>(std::ranges::lower_bound(ids, named[c]) - ids.begin());
  });
}

void gather_around(MeshPart& part) {
  std::vector<std::int32_t>& first = part.first_around;
  first.assign(part.file_ids.size() + 1, 0);
  for (const std::int32_t v : part.face_vertices) ++first[v + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  part.faces_around.resize(part.face_vertices.size());
  std::vector<std::int32_t> place(first.begin(), first.end() - 1);
  for (std::int32_t f = 0; f < part.face_count(); ++f)
    for (const std::int32_t v : part.face(f)) part.faces_around[place[v]++] = f;
}

void fetch_ghosts(const Ranks& ranks, MeshPart& part) {
  struct Known {
    std::int64_t file_id;
    glm::dvec3 position;
  };
  const auto known = fetch<Known>(ranks, part.ghosts, part.layout, [&](std::int64_t place) {
    return Known{part.file_ids[place], part.positions[place]};
  });
  for (const Known& ghost : known) {
    part.file_ids.push_back(ghost.file_id);
    part.positions.push_back(ghost.position);
  }
}

// Creases go to the owners of both ends, corners to those of their vertices.
void route_tags(const Ranks& ranks, const MeshSlice& slice, MeshPart& part) {
  std::vector<SliceCrease> both;
  std::vector<int> targets;
  for (const SliceCrease& crease : slice.creases) {
    const int a = owner_of(part.layout, crease.v0), b = owner_of(part.layout, crease.v1);
    both.push_back(crease);
    targets.push_back(a);
    if (a == b) continue;
    both.push_back(crease);
    targets.push_back(b);
  }
  auto creases = route<SliceCrease>(ranks, both,
                                    [&](const SliceCrease&, std::size_t i) { return targets[i]; });
  std::ranges::sort(creases, {}, &SliceCrease::index);
  for (const SliceCrease& crease : creases)
    part.creases.push_back({part.local_of(crease.v0), part.local_of(crease.v1), crease.sharpness,
                            crease.index, crease.file_v0, crease.file_v1});
  auto corners = route<SliceCorner>(ranks, slice.corners, [&](const SliceCorner& c, std::size_t) {
    return owner_of(part.layout, c.vertex);
  });
  std::ranges::sort(corners, {}, &SliceCorner::index);
  for (const SliceCorner& corner : corners)
    part.corners.push_back({part.local_of(corner.vertex), corner.sharpness, corner.index});
}

// Holes are few: every rank knows all.
void gather_holes(const Ranks& ranks, const MeshSlice& slice, MeshPart& part) {
  const auto all = all_gather<std::int64_t>(ranks, slice.holes);
  part.holes.assign(all.begin(), all.end());
  std::ranges::sort(part.holes);
}

}  // namespace

std::int32_t MeshPart::local_of(std::int64_t number) const {
  if (number >= layout[rank] && number < layout[rank + 1])
    return static_cast<std::int32_t>(number - layout[rank]);
  const auto found = std::ranges::lower_bound(ghosts, number);
  if (found == ghosts.end() || *found != number) return -1;
  return owned_count() + static_cast<std::int32_t>(found - ghosts.begin());
}

MeshPart make_part(const Ranks& ranks, FaceStream first_ring, MeshSlice& slice, CurveOrder order) {
  MeshPart part;
  const FaceForm form(slice.attributes);
  {
    RawVector<StreamFace> faces = faces_of(form, {first_ring});
    const FaceStream second_ring = fetch_second_ring(ranks, form, faces, order);
    if (!second_ring.empty()) faces = faces_of(form, {first_ring, second_ring});
    part.layout = order.layout;
    part.rank = ranks.rank;
    part.ghosts = ghosts_of(faces, order, ranks.rank);
    part.file_ids = std::move(order.file_ids);
    part.positions = std::move(order.positions);
    part.attributes.colors = std::move(order.colors);
    order.number_of = {};
    agree(ranks, [&] {
      take_faces(faces, part);
      take_face_attributes(form, faces, part.attributes);
    });
  }
  first_ring = {};
  fetch_ghosts(ranks, part);
  fetch_attributes(ranks, slice.attributes, part);
  gather_around(part);
  route_tags(ranks, slice, part);
  gather_holes(ranks, slice, part);
  return part;
}

void fetch_ghost_tags(const Ranks& ranks, MeshPart& part) {
  if (sum_over(ranks, std::ssize(part.creases) + std::ssize(part.corners)) == 0) return;
  // By owned vertex: its tags, as numbers along the curve; v1 is -1 for a corner.
  struct Tag {
    std::int64_t v0, v1;
    std::int64_t index, file_v0, file_v1;
    double sharpness;
  };
  std::vector<std::pair<std::int64_t, Tag>> tags;
  const auto number = [&](std::int32_t v) { return v < 0 ? -1 : part.number_of(v); };
  for (const PartCrease& c : part.creases) {
    for (const std::int32_t end : {c.v0, c.v1}) {
      if (end < 0 || end >= part.owned_count() || c.v0 < 0 || c.v1 < 0) continue;
      tags.push_back(
          {number(end), {number(c.v0), number(c.v1), c.index, c.file_v0, c.file_v1, c.sharpness}});
    }
  }
  for (const PartCorner& c : part.corners)
    tags.push_back({number(c.vertex), {number(c.vertex), -1, c.index, 0, 0, c.sharpness}});
  std::ranges::stable_sort(tags, {}, [](const auto& tag) { return tag.first; });
  std::vector<std::int64_t> asked(ranks.size, 0), counts(ranks.size, 0), asking;
  for (const std::int64_t ghost : part.ghosts) ++asked[owner_of(part.layout, ghost)];
  const auto wanted = all_to_all<std::int64_t>(ranks, part.ghosts, asked, &asking);
  RawVector<Tag> reply;
  std::size_t at = 0;
  for (int r = 0; r < ranks.size; ++r) {
    const std::size_t before = reply.size();
    for (std::int64_t k = 0; k < asking[r]; ++k, ++at) {
      const auto found =
          std::ranges::equal_range(tags, wanted[at], {}, [](const auto& tag) { return tag.first; });
      for (const auto& tag : found) reply.push_back(tag.second);
    }
    counts[r] = static_cast<std::int64_t>(reply.size() - before);
  }
  for (const Tag& tag : all_to_all<Tag>(ranks, reply, counts)) {
    const auto sharpness = static_cast<float>(tag.sharpness);
    const std::int32_t v0 = part.local_of(tag.v0);
    if (tag.v1 < 0) {
      part.ghost_corners.push_back({v0, sharpness, tag.index});
    } else {
      part.ghost_creases.push_back(
          {v0, part.local_of(tag.v1), sharpness, tag.index, tag.file_v0, tag.file_v1});
    }
  }
  std::ranges::sort(part.ghost_creases, {}, &PartCrease::index);
  std::ranges::sort(part.ghost_corners, {}, &PartCorner::index);
}

}  // namespace planish
