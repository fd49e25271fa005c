#include "planish/mesh/check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/group_by.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/core/words.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

// Each rule stands once: the yes or no on all threads, the first fault and the list of all faults
// are three ways to visit the rules.

using Kind = MeshProblemKind;

bool is_below(std::int32_t index, std::size_t count) {
  return index >= 0 && static_cast<std::size_t>(index) < count;
}

template <class Number>
std::string of_count(const std::string& what, std::size_t element, const char* verb, Number index,
                     std::size_t count) {
  return formatted("{} {} {} {} of {}", what, element, verb, index, count);
}

// Sizes that do not fit.
std::vector<MeshProblem> wrong_counts(const MeshArrays& arrays) {
  std::vector<MeshProblem> problems;
  const auto require = [&](std::size_t count, std::size_t wanted, const std::string& what) {
    if (count != 0 && count != wanted)
      problems.push_back({Kind::WrongAttributeCount, -1,
                          formatted("{} {} where {} are needed, or none", count, what, wanted)});
  };
  require(arrays.face_uvs.size(), arrays.face_vertices.size(), "corners of the texture");
  require(arrays.color_count, arrays.vertex_count, "colours");
  for (const VertexAttribute& attribute : arrays.attributes) {
    const auto width = static_cast<std::size_t>(std::max(attribute.width, 0));
    if (width == 0 || attribute.values.size() != width * arrays.vertex_count)
      problems.push_back(
          {Kind::WrongAttributeCount, -1,
           formatted("{} values of {} where {} of each of {} vertices are needed",
                     attribute.values.size(), attribute.name, width, arrays.vertex_count)});
  }
  require(arrays.face_groups.size(), arrays.face_count(), "groups of faces");
  return problems;
}

// Calls rule(kind, count, holds, message) for the rules of attributes: holds(i) and message(i) are
// of the i-th of `count` elements.
template <class Rule>
void visit_attribute_rules(const MeshArrays& a, const Rule& rule) {
  rule(
      Kind::UnknownTextureCoordinate, a.face_uvs.size(),
      [&](std::size_t c) { return a.face_uvs[c] == -1 || is_below(a.face_uvs[c], a.uv_count); },
      [&](std::size_t c) {
        return of_count("the texture coordinate of corner", c, "has number", a.face_uvs[c],
                        a.uv_count);
      });
  rule(
      Kind::UnknownGroup, a.face_groups.size(),
      [&](std::size_t f) { return is_below(a.face_groups[f], a.group_count); },
      [&](std::size_t f) {
        return of_count("the group of face", f, "has number", a.face_groups[f], a.group_count);
      });
  rule(
      Kind::UnknownCreaseEdge, a.creases.size(),
      [&](std::size_t i) { return !std::isnan(a.creases[i].sharpness); },
      [&](std::size_t i) {
        return formatted("crease {} has sharpness nan; a number from 0 is wanted, {} is infinite",
                         i, shortest(kInfiniteSharpness));
      });
  rule(
      Kind::UnknownCornerVertex, a.corners.size(),
      [&](std::size_t i) { return !std::isnan(a.corners[i].sharpness); },
      [&](std::size_t i) {
        return formatted("corner {} has sharpness nan; a number from 0 is wanted, {} is infinite",
                         i, shortest(kInfiniteSharpness));
      });
  rule(
      Kind::UnknownHole, a.hole_faces.size(),
      [&](std::size_t i) { return is_below(a.hole_faces[i], a.face_count()); },
      [&](std::size_t i) {
        return of_count("hole", i, "is face", a.hole_faces[i], a.face_count());
      });
}

// The same for the rules of faces, in an order in which each rule may trust those before it.
template <class Rule>
void visit_face_rules(const MeshArrays& a, std::int32_t least_corners, const Rule& rule) {
  const auto corner_count = static_cast<std::int64_t>(a.face_vertices.size());
  if (a.face_offsets.empty()) {
    rule(
        Kind::IndexOutOfRange, 1, [&](std::size_t) { return corner_count % 4 == 0; },
        [](std::size_t) { return "the number of quad corners is no multiple of 4"; });
  } else {
    rule(
        Kind::IndexOutOfRange, 1,
        [&](std::size_t) {
          return a.face_offsets.front() == 0 && a.face_offsets.back() == corner_count;
        },
        [](std::size_t) { return "the face offsets do not span the face corners"; });
    rule(
        Kind::IndexOutOfRange, a.face_count(),
        [&](std::size_t f) {
          const std::int32_t begin = a.face_offsets[f], end = a.face_offsets[f + 1];
          return 0 <= begin && begin <= end && end <= corner_count;
        },
        [&](std::size_t f) {
          return formatted("face {} spans corners {} to {} of {}", f, a.face_offsets[f],
                           a.face_offsets[f + 1], corner_count);
        });
    rule(
        Kind::FaceTooSmall, a.face_count(),
        [&](std::size_t f) { return a.face_offsets[f + 1] - a.face_offsets[f] >= least_corners; },
        [&](std::size_t f) {
          return formatted("face {} has {}, at least {} are needed", f,
                           counted(a.face_offsets[f + 1] - a.face_offsets[f], "corner"),
                           least_corners);
        });
  }
  rule(
      Kind::IndexOutOfRange, a.face_vertices.size(),
      [&](std::size_t c) { return is_below(a.face_vertices[c], a.vertex_count); },
      [&](std::size_t c) {
        return of_count("face corner", c, "names vertex", a.face_vertices[c], a.vertex_count);
      });
}

template <class Rule>
void visit_tag_rules(const MeshArrays& a, const Rule& rule) {
  rule(
      Kind::UnknownCreaseEdge, a.creases.size(),
      [&](std::size_t i) {
        return is_below(a.creases[i].v0, a.vertex_count) &&
               is_below(a.creases[i].v1, a.vertex_count);
      },
      [&](std::size_t i) {
        return formatted("crease {} names {}-{} of {} vertices", i, a.creases[i].v0,
                         a.creases[i].v1, a.vertex_count);
      });
  rule(
      Kind::UnknownCornerVertex, a.corners.size(),
      [&](std::size_t i) { return is_below(a.corners[i].vertex, a.vertex_count); },
      [&](std::size_t i) {
        return of_count("corner", i, "names vertex", a.corners[i].vertex, a.vertex_count);
      });
}

}  // namespace

MeshArrays arrays_of(const PolygonMesh& mesh) {
  // A mesh without offsets has no faces; its corners, if any, belong to none.
  static constexpr std::int32_t kNoFaces[] = {0};
  const std::span<const std::int32_t> offsets = mesh.face_offsets;
  return {.vertex_count = mesh.positions.size(),
          .face_offsets = offsets.empty() ? std::span<const std::int32_t>(kNoFaces) : offsets,
          .face_vertices = mesh.face_vertices,
          .uv_count = mesh.uvs.size(),
          .face_uvs = mesh.face_uvs,
          .color_count = mesh.colors.size(),
          .attributes = mesh.attributes,
          .group_count = mesh.groups.size(),
          .face_groups = mesh.face_groups,
          .hole_faces = mesh.hole_faces,
          .creases = mesh.creases,
          .corners = mesh.corners};
}

namespace {

// Without an end at the first that does not hold, so that what is compared becomes vectors.
template <class Holds>
bool hold_all(std::size_t count, const Holds& holds) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 13;
  std::atomic<bool> all{true};
  parallel_for(count, kAtOnce, [&](std::size_t begin, std::size_t end) {
    bool found = true;
    for (std::size_t i = begin; i < end; ++i) found &= holds(i);
    if (!found) all.store(false, std::memory_order_relaxed);
  });
  return all.load();
}

}  // namespace

bool attributes_are_sound(const MeshArrays& arrays) {
  bool sound = wrong_counts(arrays).empty();
  visit_attribute_rules(arrays, [&](Kind, std::size_t count, const auto& holds, const auto&) {
    sound = sound && hold_all(count, holds);
  });
  return sound;
}

void list_attribute_problems(const MeshArrays& arrays, std::vector<MeshProblem>& problems) {
  const std::vector<MeshProblem> counts = wrong_counts(arrays);
  problems.insert(problems.end(), counts.begin(), counts.end());
  visit_attribute_rules(arrays,
                        [&](Kind kind, std::size_t count, const auto& holds, const auto& message) {
                          for (std::size_t i = 0; i < count; ++i)
                            if (!holds(i))
                              problems.push_back({kind, static_cast<std::int64_t>(i), message(i)});
                        });
}

std::optional<MeshProblem> first_index_problem(const MeshArrays& arrays,
                                               std::int32_t least_corners) {
  std::optional<MeshProblem> problem;
  const auto look = [&](Kind kind, std::size_t count, const auto& holds, const auto& message) {
    if (problem) return;
    const std::size_t first = first_where(count, [&](std::size_t i) { return !holds(i); });
    if (first < count)
      problem = MeshProblem{kind, static_cast<std::int64_t>(first), message(first)};
  };
  visit_face_rules(arrays, least_corners, look);
  if (problem) return problem;
  const std::vector<MeshProblem> counts = wrong_counts(arrays);
  if (!counts.empty()) return counts.front();
  visit_attribute_rules(arrays, look);
  visit_tag_rules(arrays, look);
  return problem;
}

void require_sound_indices(const MeshArrays& arrays, std::string_view name, ErrorCode code,
                           std::int32_t least_corners) {
  const std::optional<MeshProblem> problem = first_index_problem(arrays, least_corners);
  if (problem) throw Error(code, std::string(name) + ": " + problem->message, problem->element);
}

namespace {

// Every test asks only whether all is well: where it is not, check() looks again, one element after
// another, and words the problems.

constexpr std::size_t kSoundGrain = 4096;

// Whether test(begin, end) holds on all pieces; further pieces are left out once one fails.
template <class Test>
bool holds_everywhere(std::size_t count, const Test& test) {
  std::atomic<bool> holds{true};
  parallel_for(count, kSoundGrain, [&](std::size_t begin, std::size_t end) {
    if (holds.load(std::memory_order_relaxed) && !test(begin, end))
      holds.store(false, std::memory_order_relaxed);
  });
  return holds.load();
}

bool counts_fit(const PolygonMesh& mesh) {
  const std::size_t largest =
      std::max({mesh.positions.size(), mesh.face_offsets.size(), mesh.face_vertices.size()});
  return mesh.face_offsets.size() > 1 && largest <= static_cast<std::size_t>(kMaxInt32);
}

bool names_one_twice(std::span<const std::int32_t> face, std::vector<std::int32_t>& scratch) {
  constexpr std::size_t kFew = 12;
  if (face.size() <= kFew) {
    for (std::size_t i = 1; i < face.size(); ++i)
      if (std::find(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(i), face[i]) !=
          face.begin() + static_cast<std::ptrdiff_t>(i))
        return true;
    return false;
  }
  scratch.assign(face.begin(), face.end());
  std::ranges::sort(scratch);
  return std::ranges::adjacent_find(scratch) != scratch.end();
}

// Offsets, indices and sizes of the faces; writes the lowest vertex of each.
bool faces_are_sound(const PolygonMesh& mesh, RawVector<std::int32_t>& lowest) {
  const auto corner_count = static_cast<std::int32_t>(mesh.face_vertices.size());
  if (mesh.face_offsets.front() != 0 || mesh.face_offsets.back() != corner_count) return false;
  lowest.resize(mesh.face_offsets.size() - 1);
  return holds_everywhere(lowest.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<std::int32_t> scratch;
    for (std::size_t f = begin; f < end; ++f) {
      const std::int32_t first = mesh.face_offsets[f], last = mesh.face_offsets[f + 1];
      if (first < 0 || last > corner_count || last < first + std::int64_t{3} ||
          last > first + std::int64_t{kMaxValence})
        return false;
      const auto face = mesh.face(static_cast<std::int32_t>(f));
      const auto [low, high] = std::ranges::minmax(face);
      if (low < 0 || high >= mesh.vertex_count() || names_one_twice(face, scratch)) return false;
      lowest[f] = low;
    }
    return true;
  });
}

using SummedFaces = std::vector<std::pair<std::uint64_t, std::int32_t>>;  // sum of squares, face

// Whether two of the faces have the same vertices.
bool have_duplicates(const MeshTopology& topology, SummedFaces& faces) {
  std::ranges::sort(faces);
  std::vector<std::vector<std::int32_t>> alike;
  for (std::size_t begin = 0, end; begin < faces.size(); begin = end) {
    end = begin + 1;
    while (end < faces.size() && faces[end].first == faces[begin].first) ++end;
    if (end - begin == 1) continue;
    alike.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const auto face = topology.face(faces[i].second);
      std::ranges::sort(alike.emplace_back(face.begin(), face.end()));
    }
    std::ranges::sort(alike);
    if (std::ranges::adjacent_find(alike) != alike.end()) return true;
  }
  return false;
}

// Valences, and that no two faces have the same vertices: they would share their lowest one.
bool vertices_are_sound(const MeshTopology& topology, std::span<const std::int32_t> lowest) {
  const auto count = static_cast<std::size_t>(topology.vertex_count());
  return holds_everywhere(count, [&](std::size_t begin, std::size_t end) {
    SummedFaces faces;
    for (std::size_t v = begin; v < end; ++v) {
      const auto vertex = static_cast<std::int32_t>(v);
      if (topology.valence(vertex) > kMaxValence) return false;
      std::int32_t lowest_of = 0;
      for (const std::int32_t corner : topology.corners_at(vertex))
        lowest_of += lowest[topology.face_of(corner)] == vertex ? 1 : 0;
      if (lowest_of < 2) continue;
      faces.clear();
      for (const std::int32_t corner : topology.corners_at(vertex)) {
        const std::int32_t face = topology.face_of(corner);
        if (lowest[face] != vertex) continue;
        // Faces that differ mostly differ in the sum of squares.
        std::uint64_t sum = 0;
        for (const std::int32_t other : topology.face(face))
          sum += static_cast<std::uint64_t>(other) * static_cast<std::uint64_t>(other);
        faces.emplace_back(sum, face);
      }
      if (have_duplicates(topology, faces)) return false;
    }
    return true;
  });
}

bool tags_are_known(const PolygonMesh& mesh, const MeshTopology& topology) {
  constexpr std::size_t kLongSearch = 256;  // corners around a vertex
  const auto count = topology.vertex_count();
  const auto is_vertex = [&](std::int32_t v) { return v >= 0 && v < count; };
  const bool edges = holds_everywhere(mesh.creases.size(), [&](std::size_t begin, std::size_t end) {
    return std::all_of(
        mesh.creases.begin() + static_cast<std::ptrdiff_t>(begin),
        mesh.creases.begin() + static_cast<std::ptrdiff_t>(end), [&](const CreaseEdge& crease) {
          if (!is_vertex(crease.v0) || !is_vertex(crease.v1)) return false;
          const std::size_t search = std::min(topology.corners_at(crease.v0).size(),
                                              topology.corners_at(crease.v1).size());
          return search <= kLongSearch && topology.find_edge(crease.v0, crease.v1) >= 0;
        });
  });
  return edges && std::ranges::all_of(mesh.corners, [&](const CornerVertex& corner) {
           return is_vertex(corner.vertex) && !topology.corners_at(corner.vertex).empty();
         });
}

}  // namespace

bool positions_are_finite(const PolygonMesh& mesh) {
  return holds_everywhere(mesh.positions.size(), [&](std::size_t begin, std::size_t end) {
    bool finite = true;
    for (std::size_t v = begin; v < end; ++v) {
      // Comparisons with NaN are false.
      const glm::dvec3& p = mesh.positions[v];
      finite = finite && std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
               std::abs(p.z) <= kMaxCoordinate;
    }
    return finite;
  });
}

std::optional<MeshTopology> sound_topology(const PolygonMesh& mesh) {
  RawVector<std::int32_t> lowest;
  if (!counts_fit(mesh) || !positions_are_finite(mesh) || !faces_are_sound(mesh, lowest) ||
      !attributes_are_sound(arrays_of(mesh)) || !has_extent(mesh))
    return std::nullopt;
  std::optional<MeshTopology> topology = MeshTopology::if_manifold(mesh);
  if (!topology || !vertices_are_sound(*topology, lowest) || !tags_are_known(mesh, *topology))
    return std::nullopt;
  return topology;
}

MeshTopology usable_topology(const PolygonMesh& mesh, std::string_view name) {
  std::optional<MeshTopology> topology = sound_topology(mesh);
  if (topology) return std::move(*topology);
  require_usable(mesh, name);
  return MeshTopology(mesh);
}

namespace {

std::string text_of(const glm::dvec3& position) {
  return formatted("({}, {}, {})", shortest(position.x), shortest(position.y),
                   shortest(position.z));
}

std::string vertex_name(std::int32_t vertex) { return formatted("vertex {}", vertex); }
std::string face_name(std::int32_t face) { return formatted("face {}", face); }

// For meshes with a problem: the checks in turn, each trusting what the ones before it have found
// sound.
class Inspection {
 public:
  explicit Inspection(const PolygonMesh& mesh) : mesh_(mesh) {}

  std::vector<MeshProblem> run() {
    if (!counts_fit()) return std::move(problems_);
    check_positions();
    if (!offsets_are_sound()) return std::move(problems_);
    check_faces();
    check_duplicates();
    const EdgeGroups edges = group_edges(mesh_, sound_);
    check_edges(edges);
    check_vertices(edges);
    check_tags(edges);
    list_attribute_problems(arrays_of(mesh_), problems_);
    check_extent();
    std::ranges::stable_sort(problems_, [](const MeshProblem& a, const MeshProblem& b) {
      return a.kind != b.kind ? a.kind < b.kind : a.element < b.element;
    });
    return std::move(problems_);
  }

 private:
  void add(Kind kind, std::int64_t element, std::string message) {
    problems_.push_back({kind, element, std::move(message)});
  }

  bool counts_fit();
  void check_positions();
  bool offsets_are_sound();
  void check_faces();
  void check_duplicates();
  void compare_faces(std::span<const std::int32_t> faces);
  void check_edges(const EdgeGroups& edges);
  void check_vertices(const EdgeGroups& edges);
  void check_tags(const EdgeGroups& edges);
  void check_extent();

  const PolygonMesh& mesh_;
  std::vector<MeshProblem> problems_;
  std::vector<std::uint8_t> sound_;  // by face: no problem of its own
  std::vector<std::int32_t> uses_;   // by vertex: corners of sound faces
};

bool Inspection::counts_fit() {
  const auto faces = static_cast<std::int64_t>(mesh_.face_offsets.size()) - 1;
  const auto largest = static_cast<std::int64_t>(
      std::max({mesh_.positions.size(), mesh_.face_offsets.size(), mesh_.face_vertices.size()}));
  if (faces <= 0) add(Kind::NoFaces, -1, kNoFacesMessage);
  if (largest > kMaxInt32)
    add(Kind::TooLarge, -1,
        formatted("the mesh has {} vertices, faces or corners, at most {} can be addressed",
                  largest, kMaxInt32));
  if (!problems_.empty() && largest <= kMaxInt32) check_positions();
  return problems_.empty();
}

void Inspection::check_positions() {
  for (std::int32_t vertex = 0; vertex < mesh_.vertex_count(); ++vertex) {
    const glm::dvec3& p = mesh_.positions[vertex];
    // The negated comparison catches NaN.
    const double magnitude = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    if (magnitude <= kMaxCoordinate && !std::isnan(p.x + p.y + p.z)) continue;
    const bool is_far = magnitude > kMaxCoordinate && std::isfinite(p.x + p.y + p.z);
    add(Kind::NonFinitePosition, vertex,
        vertex_name(vertex) + " is at " + text_of(p) + (is_far ? ", beyond 1e150" : ""));
  }
}

bool Inspection::offsets_are_sound() {
  const std::size_t problems_before = problems_.size();
  const auto count = static_cast<std::int32_t>(mesh_.face_vertices.size());
  for (std::int32_t face = 0; face < mesh_.face_count(); ++face) {
    const std::int32_t begin = mesh_.face_offsets[face];
    const std::int32_t end = mesh_.face_offsets[face + 1];
    const bool starts = face > 0 || begin == 0;
    const bool ends = face + 1 < mesh_.face_count() || end == count;
    if (starts && ends && 0 <= begin && begin <= end && end <= count) continue;
    add(Kind::IndexOutOfRange, face,
        formatted("{} spans corners {} to {} of {}", face_name(face), begin, end, count));
  }
  return problems_.size() == problems_before;
}

void Inspection::check_faces() {
  sound_.assign(mesh_.face_count(), 0);
  uses_.assign(mesh_.vertex_count(), 0);
  std::vector<std::int32_t> last_face(mesh_.vertex_count(), -1);
  for (std::int32_t face = 0; face < mesh_.face_count(); ++face) {
    const std::size_t problems_before = problems_.size();
    for (const std::int32_t vertex : mesh_.face(face)) {
      if (vertex < 0 || vertex >= mesh_.vertex_count()) {
        add(Kind::IndexOutOfRange, face,
            formatted("{} names vertex {} of {}", face_name(face), vertex, mesh_.vertex_count()));
        break;
      }
      if (last_face[vertex] == face) {
        add(Kind::RepeatedCorner, face,
            formatted("{} names vertex {} twice", face_name(face), vertex));
        break;
      }
      last_face[vertex] = face;
    }
    const std::int32_t size = mesh_.face_size(face);
    if (size < 3)
      add(Kind::FaceTooSmall, face,
          formatted("{} has {}, at least 3 are needed", face_name(face), counted(size, "corner")));
    if (size > kMaxValence)
      add(Kind::ValenceTooHigh, face,
          formatted("{} has {} corners, at most {} can be refined", face_name(face), size,
                    kMaxValence));
    sound_[face] = problems_.size() == problems_before;
  }
}

// Faces with the same vertices share their lowest vertex, so that only those are compared.
void Inspection::check_duplicates() {
  const auto by_lowest = group_by<std::int32_t>(mesh_.positions.size(), [&](const auto& take) {
    for (std::int32_t face = 0; face < mesh_.face_count(); ++face)
      if (sound_[face]) take(std::ranges::min(mesh_.face(face)), face);
  });
  for (std::size_t v = 0; v < mesh_.positions.size(); ++v)
    if (by_lowest.of(v).size() > 1) compare_faces(by_lowest.of(v));
  for (std::int32_t face = 0; face < mesh_.face_count(); ++face)
    if (sound_[face])
      for (const std::int32_t vertex : mesh_.face(face)) ++uses_[vertex];
}

void Inspection::compare_faces(std::span<const std::int32_t> faces) {
  struct Signature {
    std::int64_t sum;
    std::int32_t face;
  };
  std::vector<Signature> signatures;
  for (const std::int32_t face : faces) {
    // Faces that differ mostly differ in the sum of squares; those that do not are compared below.
    std::uint64_t sum = 0;
    for (const std::int32_t vertex : mesh_.face(face))
      sum += static_cast<std::uint64_t>(vertex) * static_cast<std::uint64_t>(vertex);
    signatures.push_back({static_cast<std::int64_t>(sum), face});
  }
  std::ranges::sort(signatures, {}, &Signature::sum);
  for (std::size_t begin = 0, end; begin < signatures.size(); begin = end) {
    end = begin + 1;
    while (end < signatures.size() && signatures[end].sum == signatures[begin].sum) ++end;
    if (end - begin == 1) continue;
    std::vector<std::pair<std::vector<std::int32_t>, std::int32_t>> sorted;
    for (std::size_t i = begin; i < end; ++i) {
      const auto face = mesh_.face(signatures[i].face);
      sorted.emplace_back(std::vector(face.begin(), face.end()), signatures[i].face);
      std::ranges::sort(sorted.back().first);
    }
    std::ranges::sort(sorted);
    std::size_t first = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i) {
      if (sorted[i].first != sorted[first].first) {
        first = i;
        continue;
      }
      sound_[sorted[i].second] = 0;
      add(Kind::DuplicateFace, sorted[i].second,
          formatted("face {} has the same vertices as face {}", sorted[i].second,
                    sorted[first].second));
    }
  }
}

void Inspection::check_edges(const EdgeGroups& edges) {
  edges.for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    const auto edge_name = [&] { return formatted("edge {}-{}", lower, sides.front().higher); };
    const std::int32_t first = sides.front().face, last = sides.back().face;
    if (sides.size() > 2) {
      add(Kind::NonManifoldEdge, last,
          formatted("{} has {} faces, at most 2 are possible; among them {} and {}", edge_name(),
                    sides.size(), face_name(first), face_name(last)));
    } else if (sides.size() == 2 &&
               mesh_.face_vertices[sides[0].corner] == mesh_.face_vertices[sides[1].corner]) {
      add(Kind::InconsistentWinding, last,
          formatted("{} runs along {} in the same direction as {}; turn one of them round",
                    face_name(last), edge_name(), face_name(first)));
    }
  });
}

// Corners around a vertex that share an edge are in one fan.
void Inspection::check_vertices(const EdgeGroups& edges) {
  DisjointSets fans(mesh_.face_vertices.size());
  std::vector<std::int32_t> fan_counts = uses_;
  std::vector<std::int32_t> edge_counts(mesh_.vertex_count(), 0);
  edges.for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    ++edge_counts[lower];
    ++edge_counts[sides.front().higher];
    const auto corners_of = [&](const FaceSide& side) {
      const std::int32_t next = next_corner(mesh_, side.face, side.corner);
      const bool forward = mesh_.face_vertices[side.corner] == lower;
      return forward ? std::pair(side.corner, next) : std::pair(next, side.corner);
    };
    const auto first = corners_of(sides.front());
    for (const FaceSide& side : sides.subspan(1)) {
      const auto other = corners_of(side);
      fan_counts[lower] -= fans.unite(first.first, other.first);
      fan_counts[side.higher] -= fans.unite(first.second, other.second);
    }
  });
  for (std::int32_t vertex = 0; vertex < mesh_.vertex_count(); ++vertex) {
    if (fan_counts[vertex] > 1)
      add(Kind::NonManifoldVertex, vertex,
          formatted("{} joins {} separate fans of faces; split it", vertex_name(vertex),
                    fan_counts[vertex]));
    const std::int32_t valence = std::max(edge_counts[vertex], uses_[vertex]);
    if (valence > kMaxValence)
      add(Kind::ValenceTooHigh, vertex,
          formatted("{} has {} edges, at most {} can be refined", vertex_name(vertex), valence,
                    kMaxValence));
  }
}

void Inspection::check_tags(const EdgeGroups& edges) {
  for (std::size_t i = 0; i < mesh_.creases.size(); ++i) {
    const auto [v0, v1, sharpness] = mesh_.creases[i];
    if (!edges.find(v0, v1).empty()) continue;
    const auto index = static_cast<std::int64_t>(i);
    add(Kind::UnknownCreaseEdge, index,
        formatted("crease {} names {}-{}, which is no edge of the mesh", index, v0, v1));
  }
  for (std::size_t i = 0; i < mesh_.corners.size(); ++i) {
    const std::int32_t vertex = mesh_.corners[i].vertex;
    if (vertex >= 0 && vertex < mesh_.vertex_count() && uses_[vertex] > 0) continue;
    const auto index = static_cast<std::int64_t>(i);
    add(Kind::UnknownCornerVertex, index,
        formatted("corner {} names vertex {}, which no face uses", index, vertex));
  }
}

void Inspection::check_extent() {
  if (std::ranges::find(sound_, 0) != sound_.end() || has_extent(mesh_)) return;
  add(Kind::NoExtent, -1,
      "all vertices of the faces are at " + text_of(mesh_.positions[mesh_.face_vertices.front()]) +
          ": there is no surface to make");
}

}  // namespace

std::string_view name_of(MeshProblemKind kind) {
  switch (kind) {
    case Kind::NoFaces:
      return "no-faces";
    case Kind::NonFinitePosition:
      return "non-finite-position";
    case Kind::IndexOutOfRange:
      return "index-out-of-range";
    case Kind::WrongAttributeCount:
      return "wrong-attribute-count";
    case Kind::UnknownTextureCoordinate:
      return "unknown-texture-coordinate";
    case Kind::UnknownGroup:
      return "unknown-group";
    case Kind::FaceTooSmall:
      return "face-too-small";
    case Kind::RepeatedCorner:
      return "repeated-corner";
    case Kind::DuplicateFace:
      return "duplicate-face";
    case Kind::InconsistentWinding:
      return "inconsistent-winding";
    case Kind::NonManifoldEdge:
      return "non-manifold-edge";
    case Kind::NonManifoldVertex:
      return "non-manifold-vertex";
    case Kind::UnknownCreaseEdge:
      return "unknown-crease-edge";
    case Kind::UnknownCornerVertex:
      return "unknown-corner-vertex";
    case Kind::UnknownHole:
      return "unknown-hole";
    case Kind::ValenceTooHigh:
      return "valence-too-high";
    case Kind::TooLarge:
      return "too-large";
    case Kind::NoExtent:
      return "no-extent";
  }
  return "unknown";
}

std::vector<MeshProblem> check(const PolygonMesh& mesh) {
  if (sound_topology(mesh)) return {};
  return list_problems(mesh);
}

std::vector<MeshProblem> list_problems(const PolygonMesh& mesh) { return Inspection(mesh).run(); }

namespace {

bool repair_mends(const MeshProblem& problem) {
  switch (problem.kind) {
    case Kind::FaceTooSmall:
    case Kind::RepeatedCorner:
    case Kind::DuplicateFace:
    case Kind::InconsistentWinding:
    case Kind::NonManifoldEdge:
    case Kind::NonManifoldVertex:
    case Kind::UnknownCreaseEdge:
    case Kind::UnknownCornerVertex:
    case Kind::UnknownHole:
      return true;
    default:
      return false;
  }
}

}  // namespace

void require_usable(const PolygonMesh& mesh, std::string_view name) {
  constexpr std::size_t kNamed = 10;
  const std::vector<MeshProblem> problems = check(mesh);
  if (problems.empty()) return;
  std::string message(name);
  if (problems.size() == 1) {
    message += ": " + problems.front().message;
  } else {
    message += formatted(": {} problems", problems.size());
    if (problems.size() > kNamed) message += formatted(", the first {} being", kNamed);
    message += ":";
    for (std::size_t i = 0; i < std::min(problems.size(), kNamed); ++i)
      message += "\n  " + problems[i].message;
  }
  if (std::ranges::all_of(problems, repair_mends))
    message += "; repair() mends this, as the command does but with --repair none";
  throw Error(ErrorCode::UnusableMesh, message, problems.front().element);
}

}  // namespace planish
