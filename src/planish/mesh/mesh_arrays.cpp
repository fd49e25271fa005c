// Each rule stands once: the yes or no on all threads, the first fault and the list of all faults
// are three ways to visit the rules.
#include "planish/mesh/mesh_arrays.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "planish/core/counted.h"
#include "planish/core/first_where.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

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

}  // namespace planish
