#include <algorithm>
#include <charconv>
#include <string_view>

#include "planish/core/formatted.h"
#include "planish/distributed/part_rows.h"

namespace planish {

namespace {

using Kind = MeshProblemKind;

std::int64_t file_id_of(const MeshPart& part, const SubMesh& sub, std::int32_t vertex) {
  return part.file_ids[sub.vertices[vertex]];
}
std::int64_t face_id_of(const MeshPart& part, const SubMesh& sub, std::int32_t face) {
  return part.face_ids[sub.faces[face]];
}

// The message with the file's numbers for those of the sub mesh.
std::string in_file_numbers(const MeshPart& part, const SubMesh& sub, std::string_view message) {
  std::string text;
  const auto number = [&](std::int64_t (*of)(const MeshPart&, const SubMesh&, std::int32_t)) {
    std::int32_t value = 0;
    const auto [end, error] =
        std::from_chars(message.data(), message.data() + message.size(), value);
    if (error != std::errc()) return;
    message.remove_prefix(static_cast<std::size_t>(end - message.data()));
    text += std::to_string(of(part, sub, value));
  };
  while (!message.empty()) {
    const auto take = [&](std::string_view word) {
      if (!message.starts_with(word)) return false;
      text += word;
      message.remove_prefix(word.size());
      return true;
    };
    if (take("face ") || take("the largest face, ")) {
      number(face_id_of);
    } else if (take("vertex ")) {
      number(file_id_of);
    } else if (take("edge ")) {
      number(file_id_of);
      if (take("-")) number(file_id_of);
    } else {
      text += message.front();
      message.remove_prefix(1);
    }
  }
  return text;
}

bool is_of_vertex(const MeshProblem& problem) {
  return problem.kind == Kind::NonFinitePosition || problem.kind == Kind::NonManifoldVertex ||
         (problem.kind == Kind::ValenceTooHigh && problem.message.starts_with("vertex"));
}

bool is_of_face(const MeshProblem& problem) {
  switch (problem.kind) {
    case Kind::IndexOutOfRange:
    case Kind::FaceTooSmall:
    case Kind::RepeatedCorner:
    case Kind::DuplicateFace:
    case Kind::InconsistentWinding:
    case Kind::NonManifoldEdge:
    case Kind::TooLarge:
      return problem.element >= 0;
    case Kind::ValenceTooHigh:
      return !is_of_vertex(problem);
    default:
      return false;
  }
}

struct ProblemHead {
  std::int64_t kind, element, bytes;
};

// The first few of every rank, and rank 0's count of all.
std::vector<FoundProblem> first_of_all(const Ranks& ranks, std::vector<FoundProblem> found,
                                       std::size_t most) {
  const auto in_order = [](const FoundProblem& a, const FoundProblem& b) {
    return a.kind != b.kind ? a.kind < b.kind : a.element < b.element;
  };
  std::ranges::stable_sort(found, in_order);
  found.resize(std::min(found.size(), most));
  std::vector<ProblemHead> heads;
  std::vector<char> text;
  for (const FoundProblem& problem : found) {
    heads.push_back({static_cast<std::int64_t>(problem.kind), problem.element,
                     static_cast<std::int64_t>(problem.message.size())});
    text.insert(text.end(), problem.message.begin(), problem.message.end());
  }
  const auto all_heads = gather<ProblemHead>(ranks, heads);
  const auto all_text = gather<char>(ranks, text);
  std::vector<FoundProblem> all;
  std::size_t at = 0;
  for (const ProblemHead& head : all_heads) {
    all.push_back({static_cast<Kind>(head.kind), head.element,
                   std::string(all_text.data() + at, static_cast<std::size_t>(head.bytes))});
    at += static_cast<std::size_t>(head.bytes);
  }
  std::ranges::stable_sort(all, in_order);
  return all;
}

}  // namespace

std::vector<FoundProblem> problems_of_run(const MeshPart& part, const SubMesh& sub,
                                          std::int32_t begin, std::int32_t end,
                                          const std::vector<MeshProblem>& problems) {
  const auto in_run = [&](std::int32_t v) { return v >= begin && v < end; };
  // A face is its first vertex's along the curve.
  const auto owns_face = [&](std::int64_t face) {
    return in_run(part.first_vertex(sub.faces[face]));
  };
  std::vector<FoundProblem> found;
  for (const MeshProblem& problem : problems) {
    if (is_of_vertex(problem) && in_run(sub.vertices[problem.element])) {
      found.push_back({problem.kind,
                       file_id_of(part, sub, static_cast<std::int32_t>(problem.element)),
                       in_file_numbers(part, sub, problem.message)});
    } else if (is_of_face(problem) && owns_face(problem.element)) {
      found.push_back({problem.kind,
                       face_id_of(part, sub, static_cast<std::int32_t>(problem.element)),
                       in_file_numbers(part, sub, problem.message)});
    }
  }
  return found;
}

std::vector<FoundProblem> unknown_tags(const MeshPart& part) {
  std::vector<FoundProblem> found;
  const auto owned = [&](std::int32_t v) { return v >= 0 && v < part.owned_count(); };
  const auto meet = [&](std::int32_t v0, std::int32_t v1) {
    return std::ranges::any_of(part.around(v0), [&](std::int32_t face) {
      const auto named = part.face(face);
      for (std::size_t i = 0; i < named.size(); ++i) {
        const std::int32_t next = named[(i + 1) % named.size()];
        if ((named[i] == v0 && next == v1) || (named[i] == v1 && next == v0)) return true;
      }
      return false;
    });
  };
  for (const PartCrease& crease : part.creases) {
    // The owner of its first vertex tells.
    if (!owned(crease.v0) || (crease.v1 >= 0 && meet(crease.v0, crease.v1))) continue;
    found.push_back({Kind::UnknownCreaseEdge, crease.index,
                     formatted("crease {} names {}-{}, which is no edge of the mesh", crease.index,
                               crease.file_v0, crease.file_v1)});
  }
  for (const PartCorner& corner : part.corners) {
    if (!part.around(corner.vertex).empty()) continue;
    found.push_back({Kind::UnknownCornerVertex, corner.index,
                     formatted("corner {} names vertex {}, which no face uses", corner.index,
                               part.file_ids[corner.vertex])});
  }
  return found;
}

void require_none(const Ranks& ranks, const std::vector<FoundProblem>& found,
                  const std::string& name) {
  constexpr std::int64_t kNamed = 10;
  constexpr const char* kRemedy = "; planish-mpi mends nothing, planish fit mends what it can";
  const std::int64_t count = sum_over(ranks, static_cast<std::int64_t>(found.size()));
  if (count == 0) return;
  const std::vector<FoundProblem> first = first_of_all(ranks, found, kNamed);
  agree(ranks, [&] {
    if (ranks.rank != 0) return;
    std::string message = name + ": ";
    if (count == 1) {
      message += first.front().message;
    } else {
      message += formatted("{} problems", count);
      if (count > kNamed) message += formatted(", the first {} being", kNamed);
      message += ":";
      for (std::int64_t i = 0; i < std::min(count, kNamed); ++i)
        message += "\n  " + first[i].message;
    }
    // A mesh without faces is beyond mending.
    if (first.front().element >= 0) message += kRemedy;
    throw Error(ErrorCode::UnusableMesh, message, first.front().element);
  });
}

}  // namespace planish
