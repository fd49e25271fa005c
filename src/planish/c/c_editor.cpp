#include "planish/c/editor.h"

#include <memory>
#include <string>
#include <vector>

#include "planish/c/handles.h"

namespace planish::c {
namespace {

std::vector<glm::dvec3> vectors_of(const double* values, std::size_t count) {
  std::vector<glm::dvec3> result(count);
  for (std::size_t i = 0; i < count; ++i)
    result[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  return result;
}

// The parts of every call that names vertices, before memory is taken for so many.
void require_vertices(const planish_editor* editor, const std::int32_t* vertices,
                      std::size_t count) {
  require(editor, "editor");
  require_list(vertices, count, "vertices", "count");
}

glm::dmat4 matrix_of(const double* rows) {
  glm::dmat4 matrix(1.0);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) matrix[c][r] = rows[4 * r + c];
  return matrix;
}

// Tells the caller what was done.
void tell(planish_editor* editor, const EditChange& made, planish_edit_change* change) {
  if (change == nullptr) return;
  editor->rows.clear();
  for (const RowRange& range : made.rows) editor->rows.push_back({range.first, range.count});
  planish_edit_change own;
  planish_edit_change_init(&own, sizeof own);
  own.vertices = made.vertices.data();
  own.vertex_count = made.vertices.size();
  own.control_points = made.control_points.data();
  own.control_point_count = made.control_points.size();
  own.rows = editor->rows.data();
  own.range_count = editor->rows.size();
  own.row_count = made.row_count;
  own.is_whole = made.is_whole ? 1 : 0;
  give(own, change, "change");
}

// Runs what changes an editor, and tells the caller what it did.
template <class Work>
planish_status changing(planish_editor* editor, planish_edit_change* change, const Work& work) {
  require(editor, "editor");
  EditChange made;
  run_on(editor->kept.thread_count, [&] { made = work(editor->edited->editor); });
  tell(editor, made, change);
  return PLANISH_OK;
}

// The same of what makes another editor of one: what was given by it before stays as it is.
template <class Make>
planish_status replacing(planish_editor* editor, planish_edit_change* change, const Make& make) {
  std::shared_ptr<EditedFit> next;
  EditChange made;
  run_on(editor->kept.thread_count, [&] {
    const EditedFit& now = *editor->edited;
    next = std::make_shared<EditedFit>(now.first, make(now.editor));
    made = next->editor.everything();
  });
  tell(editor, made, change);
  editor->edited = std::move(next);
  return PLANISH_OK;
}

// The edges and vertices of planish_editor_set_sharp().
struct SharpTags {
  std::vector<CreaseEdge> edges;
  std::vector<CornerVertex> corners;
};

SharpTags tags_of(const std::int32_t* edges, std::size_t edge_count, const std::int32_t* corners,
                  std::size_t corner_count, bool is_sharp) {
  const float sharpness = is_sharp ? kInfiniteSharpness : 0;
  SharpTags tags;
  tags.edges.reserve(edge_count);
  for (std::size_t i = 0; i < edge_count; ++i)
    tags.edges.push_back({edges[2 * i], edges[2 * i + 1], sharpness});
  tags.corners.reserve(corner_count);
  for (std::size_t i = 0; i < corner_count; ++i) tags.corners.push_back({corners[i], sharpness});
  return tags;
}

}  // namespace
}  // namespace planish::c

using namespace planish::c;

void planish_edit_change_init(planish_edit_change* change, size_t struct_size) {
  start({}, change, struct_size);
}

void planish_editor_arrays_init(planish_editor_arrays* arrays, size_t struct_size) {
  start({}, arrays, struct_size);
}

planish_status planish_editor_create(const planish_fit* fit, int32_t level,
                                     planish_editor** editor) {
  return call([&] {
    require(fit, "fit");
    require(editor, "editor");
    auto made = std::make_unique<planish_editor>();
    made->kept = fit->kept;
    run_on(made->kept.thread_count,
           [&] { made->edited = std::make_shared<EditedFit>(fit->whole, fit->settled(level)); });
    *editor = made.release();
    return PLANISH_OK;
  });
}

void planish_editor_free(planish_editor* editor) { delete editor; }

planish_status planish_editor_move(planish_editor* editor, const int32_t* vertices,
                                   const double* positions, size_t count,
                                   planish_edit_change* change) {
  return call([&] {
    require_vertices(editor, vertices, count);
    if (count > 0) require(positions, "positions");
    const std::vector<glm::dvec3> to = vectors_of(positions, count);
    return changing(editor, change, [&](planish::Editor& edit) {
      return edit.move({vertices, count}, to);
    });
  });
}

planish_status planish_editor_select(planish_editor* editor, const int32_t* vertices, size_t count,
                                     double radius, const int32_t** selected,
                                     const double** weights, size_t* selected_count) {
  return call([&] {
    require_vertices(editor, vertices, count);
    require(selected, "selected");
    require(weights, "weights");
    require(selected_count, "selected_count");
    editor->selection = editor->edited->editor.select({vertices, count}, radius);
    *selected = editor->selection.vertices.data();
    *weights = editor->selection.weights.data();
    *selected_count = editor->selection.vertices.size();
    return PLANISH_OK;
  });
}

planish_status planish_editor_transform(planish_editor* editor, const int32_t* vertices,
                                        const double* weights, size_t count, const double* matrix,
                                        planish_edit_change* change) {
  return call([&] {
    require_vertices(editor, vertices, count);
    require(matrix, "matrix");
    planish::Selection selection;
    selection.vertices.assign(vertices, vertices + count);
    if (weights == nullptr) {
      selection.weights.assign(count, 1.0);
    } else {
      selection.weights.assign(weights, weights + count);
    }
    return changing(editor, change, [&](planish::Editor& edit) {
      return edit.transform(selection, matrix_of(matrix));
    });
  });
}

planish_status planish_editor_set_sharp(planish_editor* editor, const int32_t* crease_edges,
                                        size_t crease_count, const int32_t* corner_vertices,
                                        size_t corner_count, int32_t is_sharp,
                                        planish_edit_change* change) {
  return call([&] {
    require(editor, "editor");
    require_list(crease_edges, crease_count, "crease_edges", "crease_count");
    require_list(corner_vertices, corner_count, "corner_vertices", "corner_count");
    const SharpTags tags =
        tags_of(crease_edges, crease_count, corner_vertices, corner_count, is_sharp != 0);
    return replacing(editor, change, [&](const planish::Editor& edit) {
      return edit.with_sharp(tags.edges, tags.corners);
    });
  });
}

planish_status planish_editor_undo(planish_editor* editor, planish_edit_change* change) {
  return call(
      [&] { return changing(editor, change, [](planish::Editor& edit) { return edit.undo(); }); });
}

planish_status planish_editor_redo(planish_editor* editor, planish_edit_change* change) {
  return call(
      [&] { return changing(editor, change, [](planish::Editor& edit) { return edit.redo(); }); });
}

planish_status planish_editor_settle(planish_editor* editor, planish_edit_change* change) {
  return call([&] {
    return changing(editor, change, [](planish::Editor& edit) { return edit.settle(); });
  });
}

planish_status planish_editor_refit(planish_editor* editor, planish_edit_change* change) {
  return call([&] {
    require(editor, "editor");
    return replacing(editor, change, [](const planish::Editor& edit) { return edit.refitted(); });
  });
}

planish_status planish_editor_view(const planish_editor* editor, planish_editor_arrays* arrays) {
  return call([&] {
    require(editor, "editor");
    const planish::Editor& edit = editor->edited->editor;
    planish_editor_arrays own;
    planish_editor_arrays_init(&own, sizeof own);
    own.points = &edit.points()[0].x;
    own.point_count = edit.points().size();
    own.row_count = edit.positions().size();
    if (own.row_count > 0) {
      own.positions = &edit.positions()[0].x;
      own.normals = &edit.normals()[0].x;
    }
    own.error_bound = edit.error_bound();
    own.can_undo = edit.can_undo() ? 1 : 0;
    own.can_redo = edit.can_redo() ? 1 : 0;
    give(own, arrays, "arrays");
    return PLANISH_OK;
  });
}

planish_status planish_editor_fit(const planish_editor* editor, planish_fit** fit) {
  return call([&] {
    require(editor, "editor");
    require(fit, "fit");
    auto made = std::make_unique<planish_fit>();
    made->kept = editor->kept;
    run_on(made->kept.thread_count,
           [&] { made->fitted = planish::edited(*editor->edited->first, editor->edited->editor); });
    *fit = made.release();
    return PLANISH_OK;
  });
}

planish_status planish_editor_queries(planish_editor* editor, planish_queries** queries) {
  return call([&] {
    require(editor, "editor");
    require(queries, "queries");
    auto made = std::make_unique<planish_queries>();
    made->source = editor->edited;
    made->thread_count = editor->kept.thread_count;
    run_on(made->thread_count, [&] { made->queries = &editor->edited->editor.queries(); });
    *queries = made.release();
    return PLANISH_OK;
  });
}
