#include "planish/job/apply_moves.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/refuse.h"
#include "planish/edit/editor.h"

namespace planish {
namespace {

// Vertices of the mesh as it was fitted by those of the input: several where sheets were separated.
class VerticesOfInput {
 public:
  explicit VerticesOfInput(const FittedMesh& fitted)
      : sources_(fitted.source_vertices), order_(sources_.size()) {
    count_ = fitted.mesh.vertex_count();
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::stable_sort(order_, {}, [&](std::int32_t v) { return source(v); });
  }

  // Calls take(vertex) for all of a vertex of the input.
  template <class Take>
  void for_each(std::int32_t given, const std::string& where, const Take& take) const {
    if (sources_.empty()) {
      if (given >= count_)
        refuse(where, "there is no vertex {}; the mesh has 0 to {}", given, count_ - 1);
      return take(given);
    }
    const auto found =
        std::ranges::equal_range(order_, given, {}, [&](std::int32_t v) { return source(v); });
    if (found.empty())
      refuse(where,
             "there is no vertex {} once the mesh is mended: it is not in the "
             "input, or became another",
             given);
    for (const std::int32_t vertex : found) take(vertex);
  }

 private:
  [[nodiscard]] std::int32_t source(std::int32_t v) const { return sources_[v]; }

  std::span<const std::int32_t> sources_;
  std::vector<std::int32_t> order_;
  std::int32_t count_ = 0;
};

void apply_move(Editor& editor, const VerticesOfInput& input, const SceneMove& move) {
  if (move.undo > 0) {
    for (std::int64_t i = 0; i < move.undo; ++i) {
      if (!editor.can_undo()) refuse(move.where, "there are no {} moves to take back", move.undo);
      editor.undo();
    }
    return;
  }
  std::vector<std::int32_t> vertices;
  std::vector<glm::dvec3> to;
  for (std::size_t i = 0; i < move.vertices.size(); ++i) {
    input.for_each(move.vertices[i], move.where, [&](std::int32_t vertex) {
      vertices.push_back(vertex);
      if (!move.to.empty()) to.push_back(move.to[i]);
    });
  }
  try {
    if (!move.to.empty()) {
      editor.move(vertices, to);
    } else if (move.radius > 0) {
      editor.transform(editor.select(vertices, move.radius), move.map);
    } else {
      Selection all{vertices, std::vector<double>(vertices.size(), 1.0)};
      editor.transform(all, move.map);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    refuse(move.where, error.what());
  }
}

// The editor of all moves; why there is none stands where they do.
Editor editor_of(const FittedMesh& fitted, const SceneMove& first, int undo_steps) {
  try {
    return Editor(fitted, EditorOptions{0, fitted.options, undo_steps});
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    refuse(first.where, error.what());
  }
}

}  // namespace

MovedFigures apply_moves(FittedMesh& fitted, std::span<const SceneMove> moves) {
  const VerticesOfInput input(fitted);
  Editor editor = editor_of(fitted, moves.front(), static_cast<int>(moves.size()));
  for (const SceneMove& move : moves) apply_move(editor, input, move);
  MovedFigures figures;
  figures.moves = std::ssize(moves);
  const auto points = editor.points();
  for (std::size_t v = 0; v < points.size(); ++v) {
    const double way = glm::length(points[v] - fitted.mesh.positions[v]);
    if (way == 0) continue;
    ++figures.vertices;
    figures.farthest = std::max(figures.farthest, way / fitted.fit.placement.diagonal);
  }
  FittedMesh now = edited(fitted, editor);
  now.fit.timing = fitted.fit.timing;
  fitted = std::move(now);
  return figures;
}

}  // namespace planish
