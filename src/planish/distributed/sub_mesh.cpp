#include "planish/distributed/sub_mesh.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "planish/distributed/part_attributes.h"
#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

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
