#include "planish/distributed/mesh_part.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/files/tiles/tile.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

// The colours of a slice's vertices, sent to where these stand along the curve; takes them.
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

// Fetches what rides on a part and is kept elsewhere: the ghosts' colours, the values of texture
// coordinates, whose numbers the part has; takes the slice's.
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

// Gives a sub mesh the attributes of its vertices, corners and faces. Texture coordinates are
// numbered in the order of the file, as rows of them are.
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

struct CurveVertex {
  std::uint64_t key;
  std::int64_t file_id;
  glm::dvec3 position;

  friend bool operator<(const CurveVertex& a, const CurveVertex& b) {
    return a.key != b.key ? a.key < b.key : a.file_id < b.file_id;
  }
};

using CurveVertices = RawVector<CurveVertex>;

CurveVertices with_keys(const Ranks& ranks, const MeshSlice& slice) {
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  for (const glm::dvec3& position : slice.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  MPI_Allreduce(MPI_IN_PLACE, &low.x, 3, MPI_DOUBLE, MPI_MIN, ranks.comm);
  MPI_Allreduce(MPI_IN_PLACE, &high.x, 3, MPI_DOUBLE, MPI_MAX, ranks.comm);
  const glm::dvec3 extent = high - low;
  const CurveBox box{low, std::max({extent.x, extent.y, extent.z})};
  CurveVertices result(slice.positions.size());
  parallel_each(result.size(), 4096, [&](std::size_t i) {
    result[i] = {hilbert_key(slice.positions[i], box),
                 slice.vertices[ranks.rank] + static_cast<std::int64_t>(i), slice.positions[i]};
  });
  return result;
}

// Where the runs of ranks 1, 2, ... begin, from samples of every rank's sorted vertices.
std::vector<CurveVertex> splitters_of(const Ranks& ranks, const CurveVertices& sorted) {
  constexpr std::size_t kSamples = 64;
  const CurveVertex last{std::numeric_limits<std::uint64_t>::max(), 0, {}};
  std::vector<CurveVertex> samples(kSamples, last), all(kSamples * ranks.size, last);
  for (std::size_t i = 0; i < kSamples && !sorted.empty(); ++i)
    samples[i] = sorted[sorted.size() * i / kSamples];
  constexpr int kBytes = kSamples * sizeof(CurveVertex);
  MPI_Allgather(samples.data(), kBytes, MPI_BYTE, all.data(), kBytes, MPI_BYTE, ranks.comm);
  std::ranges::sort(all, std::less());
  std::vector<CurveVertex> splitters;
  for (int r = 1; r < ranks.size; ++r) splitters.push_back(all[kSamples * r]);
  return splitters;
}

// Ascending over all ranks, in runs of whole blocks.
CurveVertices sorted_in_blocks(const Ranks& ranks, CurveVertices vertices,
                               std::int64_t block_vertices) {
  oneapi::tbb::parallel_sort(vertices.begin(), vertices.end());
  if (ranks.size == 1) return vertices;
  const std::vector<CurveVertex> splitters = splitters_of(ranks, vertices);
  vertices = route<CurveVertex>(ranks, vertices, [&](const CurveVertex& vertex, std::size_t) {
    return static_cast<int>(std::upper_bound(splitters.begin(), splitters.end(), vertex) -
                            splitters.begin());
  });
  oneapi::tbb::parallel_sort(vertices.begin(), vertices.end());
  const auto count = static_cast<std::int64_t>(vertices.size());
  const std::int64_t first = sum_before(ranks, count), total = sum_over(ranks, count);
  Layout shares = even_layout((total + block_vertices - 1) / block_vertices, ranks.size);
  for (std::int64_t& share : shares) share = std::min(share * block_vertices, total);
  return route<CurveVertex>(ranks, vertices, [&](const CurveVertex&, std::size_t i) {
    return owner_of(shares, first + static_cast<std::int64_t>(i));
  });
}

}  // namespace

CurveOrder order_along_curve(const Ranks& ranks, MeshSlice& slice, std::int64_t block_vertices) {
  CurveVertices vertices = with_keys(ranks, slice);
  slice.positions = {};
  vertices = sorted_in_blocks(ranks, std::move(vertices), block_vertices);
  CurveOrder order;
  order.layout = layout_of(ranks, static_cast<std::int64_t>(vertices.size()));
  struct Numbered {
    std::int64_t file_id, number;
  };
  RawVector<Numbered> pairs(vertices.size());
  order.file_ids.resize(vertices.size());
  order.positions.resize(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    order.file_ids[i] = vertices[i].file_id;
    order.positions[i] = vertices[i].position;
    pairs[i] = {vertices[i].file_id, order.layout[ranks.rank] + static_cast<std::int64_t>(i)};
  }
  vertices = {};
  const std::int64_t first = slice.vertices[ranks.rank];
  order.number_of.resize(slice.vertices[ranks.rank + 1] - first);
  pairs = route<Numbered>(ranks, pairs, [&](const Numbered& pair, std::size_t) {
    return owner_of(slice.vertices, pair.file_id);
  });
  for (const Numbered& pair : pairs) order.number_of[pair.file_id - first] = pair.number;
  order.colors = colors_along_curve(ranks, slice.attributes, order);
  return order;
}

namespace {

// Numbers along the curve of the vertices that a slice names, each asked for once.
class NumberTable {
 public:
  NumberTable(const Ranks& ranks, const MeshSlice& slice, const CurveOrder& order) {
    const auto for_all = [&](const auto& take) {
      for (const std::int64_t vertex : slice.face_vertices) take(vertex);
      for (const SliceCrease& crease : slice.creases) {
        take(crease.v0);
        take(crease.v1);
      }
      for (const SliceCorner& corner : slice.corners) take(corner.vertex);
    };
    std::int64_t last = -1;
    std::size_t count = 0;
    first_ = slice.vertex_total();
    for_all([&](std::int64_t vertex) {
      first_ = std::min(first_, vertex);
      last = std::max(last, vertex);
      ++count;
    });
    if (count == 0) first_ = last + 1;
    const auto range = static_cast<std::size_t>(last + 1 - first_);
    // Files usually name near vertices, so that a table over the range is smaller than a list.
    is_dense_ = range <= 2 * count;
    if (is_dense_) {
      numbers_.assign(range, -1);
      for_all([&](std::int64_t vertex) { numbers_[vertex - first_] = 0; });
      for (std::size_t i = 0; i < range; ++i)
        if (numbers_[i] == 0) ids_.push_back(first_ + static_cast<std::int64_t>(i));
    } else {
      ids_.reserve(count);
      for_all([&](std::int64_t vertex) { ids_.push_back(vertex); });
      std::ranges::sort(ids_);
      ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    }
    const auto fetched = fetch<std::int64_t>(
        ranks, ids_, slice.vertices, [&](std::int64_t place) { return order.number_of[place]; });
    if (is_dense_) {
      for (std::size_t i = 0; i < ids_.size(); ++i) numbers_[ids_[i] - first_] = fetched[i];
      ids_ = {};
    } else {
      numbers_.assign(fetched.begin(), fetched.end());
    }
  }

  [[nodiscard]] std::int64_t of(std::int64_t file_id) const {
    if (is_dense_) return numbers_[file_id - first_];
    return numbers_[std::ranges::lower_bound(ids_, file_id) - ids_.begin()];
  }

 private:
  bool is_dense_ = true;
  std::int64_t first_ = 0;
  std::vector<std::int64_t> ids_, numbers_;
};

}  // namespace

FaceStream send_first_ring(const Ranks& ranks, MeshSlice& slice, const CurveOrder& order) {
  {
    const NumberTable numbers(ranks, slice, order);
    for (std::int64_t& vertex : slice.face_vertices) vertex = numbers.of(vertex);
    for (SliceCrease& crease : slice.creases) {
      crease.v0 = numbers.of(crease.v0);
      crease.v1 = numbers.of(crease.v1);
    }
    for (SliceCorner& corner : slice.corners) corner.vertex = numbers.of(corner.vertex);
  }
  const std::int64_t first_face = slice.faces[ranks.rank];
  SliceAttributes& attributes = slice.attributes;
  const FaceForm form(attributes);
  std::vector<int> owners;
  const auto for_owners = [&](std::int64_t face, const auto& take) {
    owners.clear();
    for (const std::int64_t number : slice.face(face))
      owners.push_back(owner_of(order.layout, number));
    std::ranges::sort(owners);
    owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
    for (const int owner : owners) take(owner);
  };
  std::vector<std::int64_t> counts(ranks.size, 0);
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    for_owners(f, [&](int owner) {
      counts[owner] += form.length(static_cast<std::int64_t>(slice.face(f).size()));
    });
  std::vector<std::int64_t> places(counts.size(), 0);
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), std::int64_t{0});
  FaceStream send(static_cast<std::size_t>(places.back() + counts.back()));
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    for_owners(f, [&](int owner) {
      const auto corners = slice.face(f);
      std::int64_t& at = places[owner];
      send[at++] = first_face + f;
      send[at++] = static_cast<std::int64_t>(corners.size());
      at = std::ranges::copy(corners, send.begin() + at).out - send.begin();
      if (form.has_uvs) {
        const auto uvs =
            std::span(attributes.face_uvs).subspan(slice.face_offsets[f], corners.size());
        at = std::ranges::copy(uvs, send.begin() + at).out - send.begin();
      }
      if (form.has_groups) send[at++] = attributes.face_groups[f];
    });
  slice.face_offsets = {0};
  slice.face_vertices = {};
  attributes.face_uvs = {};
  attributes.face_groups = {};
  return all_to_all<std::int64_t>(ranks, send, counts);
}

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

std::shared_ptr<const MeshTopology> topology_of_sound(const PolygonMesh& mesh) {
  std::optional<MeshTopology> topology = sound_topology(mesh);
  // Nothing where all vertices are at one place, which is no problem of a part.
  if (!topology) topology.emplace(mesh);
  return std::make_shared<const MeshTopology>(std::move(*topology));
}

SubMeshMaker::SubMeshMaker(const MeshPart& part)
    : part_(part),
      face_stamps_(part.face_ids.size(), 0),
      vertex_stamps_(part.file_ids.size(), 0),
      whole_stamps_(part.file_ids.size(), 0),
      numbers_(part.file_ids.size(), -1) {}

void SubMeshMaker::take_around(std::int32_t vertex, std::vector<std::int32_t>& faces) {
  whole_stamps_[vertex] = stamp_;
  for (const std::int32_t face : part_.around(vertex))
    if (std::exchange(face_stamps_[face], stamp_) != stamp_) faces.push_back(face);
}

void SubMeshMaker::take_vertices(std::span<const std::int32_t> faces,
                                 std::vector<std::int32_t>& vertices) {
  for (const std::int32_t face : faces)
    for (const std::int32_t vertex : part_.face(face))
      if (std::exchange(vertex_stamps_[vertex], stamp_) != stamp_) vertices.push_back(vertex);
}

// The faces whose first vertex is in the run.
void SubMeshMaker::take_own(std::int32_t begin, std::int32_t end) {
  if (first_vertices_.empty()) {
    for (std::int32_t f = 0; f < part_.face_count(); ++f)
      first_vertices_.push_back(part_.first_vertex(f));
  }
  for (std::int32_t v = begin; v < end; ++v)
    for (const std::int32_t face : part_.around(v))
      if (first_vertices_[face] == v && std::exchange(face_stamps_[face], stamp_) != stamp_)
        faces_.push_back(face);
  own_ = faces_;
  std::ranges::sort(own_);
}

void SubMeshMaker::choose_faces(std::int32_t begin, std::int32_t end, Rings rings) {
  faces_.clear();
  vertices_.clear();
  own_.clear();
  if (rings == Rings::None || rings == Rings::Whole) {
    take_own(begin, end);
  } else {
    for (std::int32_t v = begin; v < end; ++v) take_around(v, faces_);
  }
  take_vertices(faces_, vertices_);
  if (rings == Rings::Two || rings == Rings::TwoTagged || rings == Rings::Whole) {
    const std::size_t inner = vertices_.size();
    std::vector<std::int32_t> outer;
    for (std::size_t i = 0; i < inner; ++i) take_around(vertices_[i], outer);
    take_vertices(outer, vertices_);
    faces_.insert(faces_.end(), outer.begin(), outer.end());
  }
  std::ranges::sort(faces_);
  std::ranges::sort(vertices_, {}, [&](std::int32_t v) { return part_.file_ids[v]; });
}

// Corners at vertices of which some faces are missing, by vertex: each face is walked once.
void SubMeshMaker::list_rim() {
  rim_.clear();
  for (const std::int32_t face : faces_) {
    const std::int32_t first = part_.face_offsets[face], end = part_.face_offsets[face + 1];
    for (std::int32_t c = first; c < end; ++c) {
      const std::int32_t vertex = part_.face_vertices[c];
      if (whole_stamps_[vertex] == stamp_) continue;
      const std::int32_t next = c + 1 < end ? c + 1 : first, last = c > first ? c - 1 : end - 1;
      rim_.push_back({vertex, c, part_.face_vertices[next], part_.face_vertices[last]});
    }
  }
  std::ranges::stable_sort(rim_, {}, &RimCorner::vertex);
}

// One number a fan of the vertex's faces here: corners whose faces share a neighbour of it.
void SubMeshMaker::split_fans(std::int32_t vertex, SubMesh& sub) {
  const auto uses = std::ranges::equal_range(rim_, vertex, {}, &RimCorner::vertex);
  DisjointSets fans(uses.size());
  std::vector<std::pair<std::int32_t, std::int32_t>> neighbours;  // with their use
  for (std::int32_t i = 0; i < std::ssize(uses); ++i) {
    neighbours.emplace_back(uses[i].next, i);
    neighbours.emplace_back(uses[i].last, i);
  }
  std::ranges::sort(neighbours);
  for (std::size_t k = 1; k < neighbours.size(); ++k)
    if (neighbours[k].first == neighbours[k - 1].first)
      fans.unite(neighbours[k].second, neighbours[k - 1].second);
  numbers_[vertex] = static_cast<std::int32_t>(sub.vertices.size());
  std::vector<std::int32_t> of_fan(uses.size(), -1);
  for (std::int32_t i = 0; i < std::ssize(uses); ++i) {
    std::int32_t& number = of_fan[fans.find(i)];
    if (number < 0) {
      number = static_cast<std::int32_t>(sub.vertices.size());
      sub.vertices.push_back(vertex);
    }
    corner_numbers_.push_back(uses[i].corner);
    corner_numbers_.push_back(number);
  }
  sub.copy_count += static_cast<std::int32_t>(sub.vertices.size()) - numbers_[vertex] - 1;
}

void SubMeshMaker::number_vertices(SubMesh& sub) {
  corner_numbers_.clear();
  list_rim();
  for (const std::int32_t vertex : vertices_) {
    if (whole_stamps_[vertex] == stamp_) {
      numbers_[vertex] = static_cast<std::int32_t>(sub.vertices.size());
      sub.vertices.push_back(vertex);
    } else {
      split_fans(vertex, sub);
    }
  }
  sub.mesh.positions.reserve(sub.vertices.size());
  for (const std::int32_t vertex : sub.vertices)
    sub.mesh.positions.push_back(part_.positions[vertex]);
}

bool SubMeshMaker::is_edge(std::int32_t v0, std::int32_t v1) const {
  for (const std::int32_t face : part_.around(v0)) {
    const auto named = part_.face(face);
    for (std::size_t i = 0; i < named.size(); ++i) {
      const std::int32_t next = named[(i + 1) % named.size()];
      if ((named[i] == v0 && next == v1) || (named[i] == v1 && next == v0)) return true;
    }
  }
  return false;
}

void SubMeshMaker::add_tags(std::int32_t begin, std::int32_t end, SubMesh& sub) {
  const auto in_run = [&](std::int32_t v) { return v >= begin && v < end; };
  for (const PartCrease& crease : part_.creases) {
    if (!in_run(crease.v0) && !in_run(crease.v1)) continue;
    if (crease.v0 < 0 || crease.v1 < 0) continue;
    const bool is_here =
        in_run(crease.v0) ? is_edge(crease.v0, crease.v1) : is_edge(crease.v1, crease.v0);
    if (is_here)
      sub.mesh.creases.push_back({numbers_[crease.v0], numbers_[crease.v1], crease.sharpness});
  }
  for (const PartCorner& corner : part_.corners)
    if (in_run(corner.vertex) && !part_.around(corner.vertex).empty())
      sub.mesh.corners.push_back({numbers_[corner.vertex], corner.sharpness});
}

void SubMeshMaker::add_whole(SubMesh& sub) {
  add_all_tags(sub);
  sub.is_own.resize(faces_.size());
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    sub.is_own[f] = std::ranges::binary_search(own_, faces_[f]) ? 1 : 0;
    if (part_.is_hole(faces_[f])) sub.mesh.hole_faces.push_back(static_cast<std::int32_t>(f));
  }
}

// In the order of the file, each once.
void SubMeshMaker::add_all_tags(SubMesh& sub) {
  const auto is_whole = [&](std::int32_t v) { return v >= 0 && whole_stamps_[v] == stamp_; };
  const auto is_here = [&](std::int32_t v) { return v >= 0 && vertex_stamps_[v] == stamp_; };
  std::int64_t last = -1;
  const auto add_crease = [&](const PartCrease& c) {
    if (c.index == last || !is_here(c.v0) || !is_here(c.v1)) return;
    const bool is_met =
        (is_whole(c.v0) && is_edge(c.v0, c.v1)) || (is_whole(c.v1) && is_edge(c.v1, c.v0));
    if (!is_met) return;
    last = c.index;
    sub.mesh.creases.push_back({numbers_[c.v0], numbers_[c.v1], c.sharpness});
  };
  std::size_t ghost = 0;
  for (const PartCrease& crease : part_.creases) {
    for (; ghost < part_.ghost_creases.size() && part_.ghost_creases[ghost].index < crease.index;
         ++ghost)
      add_crease(part_.ghost_creases[ghost]);
    add_crease(crease);
  }
  for (; ghost < part_.ghost_creases.size(); ++ghost) add_crease(part_.ghost_creases[ghost]);
  std::vector<PartCorner> corners;
  for (const auto* list : {&part_.corners, &part_.ghost_corners})
    for (const PartCorner& corner : *list)
      if (is_whole(corner.vertex)) corners.push_back(corner);
  std::ranges::sort(corners, {}, &PartCorner::index);
  for (const PartCorner& corner : corners)
    sub.mesh.corners.push_back({numbers_[corner.vertex], corner.sharpness});
}

SubMesh SubMeshMaker::make(std::int32_t begin, std::int32_t end, Rings rings) {
  ++stamp_;
  SubMesh sub;
  choose_faces(begin, end, rings);
  number_vertices(sub);
  sub.faces = faces_;
  for (const std::int32_t face : faces_) {
    for (const std::int32_t vertex : part_.face(face))
      sub.mesh.face_vertices.push_back(numbers_[vertex]);
    sub.mesh.face_offsets.push_back(static_cast<std::int32_t>(sub.mesh.face_vertices.size()));
  }
  // Corners of copied vertices.
  for (std::size_t i = 0; i < corner_numbers_.size(); i += 2) {
    const auto face =
        static_cast<std::int32_t>(std::ranges::upper_bound(part_.face_offsets, corner_numbers_[i]) -
                                  part_.face_offsets.begin() - 1);
    const auto place = std::ranges::lower_bound(faces_, face) - faces_.begin();
    const std::int32_t within = corner_numbers_[i] - part_.face_offsets[face];
    sub.mesh.face_vertices[sub.mesh.face_offsets[place] + within] = corner_numbers_[i + 1];
  }
  if (rings == Rings::One || rings == Rings::Two) add_tags(begin, end, sub);
  if (rings == Rings::TwoTagged) add_all_tags(sub);
  if (rings == Rings::Whole) {
    add_whole(sub);
    add_attributes(part_, sub);
  }
  return sub;
}

}  // namespace planish
