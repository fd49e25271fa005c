#include "planish/mesh/check.h"

#include <algorithm>
#include <cmath>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/group_by.h"
#include "planish/core/number_text.h"
#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/mesh_arrays.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

using Kind = MeshProblemKind;

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
