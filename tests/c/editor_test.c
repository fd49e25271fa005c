/* Vertices of a torus move through the C header: what changes is named, all else keeps its bits,
 * and the surface is that of a fit of the moved mesh. */
#include <math.h>
#include <planish/c/editor.h>
#include <stdlib.h>
#include <string.h>

#include "torus.h"

static planish_fit* fit_of(planish_mesh* mesh, const char* method) {
  planish_options* options = options_with("interpolation", method);
  planish_fit* fit = fitted(mesh, options);
  planish_options_free(options);
  planish_mesh_free(mesh);
  return fit;
}

static planish_editor_arrays view_of(const planish_editor* editor) {
  planish_editor_arrays arrays;
  planish_editor_arrays_init(&arrays, sizeof arrays);
  EXPECT(planish_editor_view(editor, &arrays) == PLANISH_OK);
  return arrays;
}

static planish_editor* editor_of(const char* method, int level) {
  planish_fit* fit = fit_of(torus(), method);
  planish_editor* editor = NULL;
  EXPECT(planish_editor_create(fit, level, &editor) == PLANISH_OK);
  planish_fit_free(fit); /* which the editor does not need */
  return editor;
}

static double distance(const double* a, const double* b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return sqrt(x * x + y * y + z * z);
}

/* The rows of the editor's own fit, evaluated anew, and its errors. */
static void check_fit(const planish_editor* editor) {
  const planish_editor_arrays now = view_of(editor);
  planish_fit* fit = NULL;
  planish_surface* surface = NULL;
  planish_surface_arrays arrays;
  planish_fit_info info;
  double largest = 0, off = 0;
  size_t i;
  planish_surface_arrays_init(&arrays, sizeof arrays);
  planish_fit_info_init(&info, sizeof info);
  EXPECT(planish_editor_fit(editor, &fit) == PLANISH_OK);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK && info.converged);
  EXPECT(planish_fit_evaluate(fit, 2, &surface) == PLANISH_OK);
  EXPECT(planish_surface_view(surface, &arrays) == PLANISH_OK);
  EXPECT(arrays.vertex_count == now.row_count && arrays.base_count == kCount);
  for (i = 0; i < now.row_count; ++i)
    largest = fmax(largest, distance(arrays.positions + 3 * i, now.positions + 3 * i));
  EXPECT(largest < 1e-12);
  for (i = 0; i < kCount; ++i)
    off = fmax(off, distance(arrays.positions + 3 * i, now.points + 3 * arrays.base_vertices[i]));
  EXPECT(off / info.diagonal <= now.error_bound + 1e-14 && now.error_bound <= 1e-6);
  EXPECT(fabs(info.max_error - off / info.diagonal) < 1e-13);
  EXPECT(info.rms_error > 0 && info.rms_error <= info.max_error);
  planish_surface_free(surface);
  planish_fit_free(fit);
}

static void test_moves(const char* method) {
  planish_editor* editor = editor_of(method, 2);
  planish_edit_change change;
  planish_editor_arrays now;
  const int32_t vertices[] = {700, 5, 700};
  double to[9], rest, *before;
  size_t i, r;
  int64_t named = 0, next = 0;
  planish_edit_change_init(&change, sizeof change);
  now = view_of(editor);
  EXPECT(now.point_count == kCount && now.row_count == 16 * kCount && !now.can_undo);
  rest = now.points[3 * 5 + 2];
  before = malloc(3 * now.row_count * sizeof *before);
  memcpy(before, now.positions, 3 * now.row_count * sizeof *before);
  for (i = 0; i < 3; ++i) {
    memcpy(to + 3 * i, now.points + 3 * vertices[i], 3 * sizeof *to);
    to[3 * i + 2] += 0.01 * (double)(i + 1);
  }
  EXPECT(planish_editor_move(editor, vertices, to, 3, &change) == PLANISH_OK);
  EXPECT(change.vertex_count == 2 && change.vertices[0] == 5 && change.vertices[1] == 700);
  EXPECT(change.control_point_count >= 2 && !change.is_whole && change.range_count > 1);
  EXPECT(now.points[3 * 700 + 2] == to[8] && now.points[3 * 5 + 2] == to[5]); /* in place */
  for (r = 0; r < change.range_count; ++r) {
    const planish_row_range range = change.rows[r];
    EXPECT(range.first >= next && range.count > 0);
    EXPECT(memcmp(before + 3 * next, now.positions + 3 * next,
                  3 * (size_t)(range.first - next) * sizeof *before) == 0);
    next = range.first + range.count;
    named += range.count;
  }
  EXPECT(memcmp(before + 3 * next, now.positions + 3 * next,
                3 * (now.row_count - (size_t)next) * sizeof *before) == 0);
  EXPECT(named == change.row_count && named < (int64_t)now.row_count / 2);
  check_fit(editor);

  EXPECT(view_of(editor).can_undo && !view_of(editor).can_redo);
  EXPECT(planish_editor_undo(editor, &change) == PLANISH_OK && change.vertex_count == 2);
  EXPECT(view_of(editor).can_redo && now.points[3 * 5 + 2] == rest);
  for (i = 0, named = 0; i < now.row_count; ++i)
    named += distance(before + 3 * i, now.positions + 3 * i) > 1e-5;
  EXPECT(named == 0);
  EXPECT(planish_editor_redo(editor, NULL) == PLANISH_OK && now.points[3 * 5 + 2] == to[5]);
  EXPECT(planish_editor_redo(editor, &change) == PLANISH_OK && change.row_count == 0);
  EXPECT(planish_editor_settle(editor, &change) == PLANISH_OK && change.is_whole);
  EXPECT(change.row_count == (int64_t)now.row_count && change.vertex_count == 0);
  check_fit(editor);
  free(before);
  planish_editor_free(editor);
}

static void test_selection(void) {
  /* A quarter turn about z and a step along it. */
  static const double kTurn[12] = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.5};
  planish_editor* editor = editor_of("progressive", 1);
  const int32_t *found = NULL, centre = 100;
  const double* weights = NULL;
  static double before[3 * kCount];
  planish_editor_arrays now;
  size_t count = 0, i;
  int d;
  now = view_of(editor);
  EXPECT(planish_editor_select(editor, &centre, 1, 0.15, &found, &weights, &count) == PLANISH_OK);
  EXPECT(count > 9 && count < 60 && found[0] == centre && weights[0] == 1);
  memcpy(before, now.points, sizeof before);
  EXPECT(planish_editor_transform(editor, found, weights, count, kTurn, NULL) == PLANISH_OK);
  for (i = 0; i < count; ++i) {
    const double* p = before + 3 * found[i];
    const double whole[] = {-p[1], p[0], p[2] + 0.5};
    for (d = 0; d < 3; ++d)
      EXPECT(fabs(now.points[3 * found[i] + d] - (p[d] + weights[i] * (whole[d] - p[d]))) < 1e-12);
  }
  EXPECT(planish_editor_undo(editor, NULL) == PLANISH_OK);
  EXPECT(planish_editor_transform(editor, &centre, NULL, 1, kTurn, NULL) == PLANISH_OK);
  EXPECT(fabs(now.points[3 * centre] + before[3 * centre + 1]) < 1e-12);
  planish_editor_free(editor);
}

static void test_creases(const char* method) {
  planish_editor* editor = editor_of(method, 2);
  planish_queries* smooth = NULL;
  planish_closest_answers answers;
  planish_edit_change change;
  planish_editor_arrays now;
  int32_t ring[2 * kAround], absent[2] = {0, 40};
  const int32_t corner = 5, moved = 700;
  double to[3], answered[3], away;
  size_t smooth_rows, sharp_rows;
  int k;
  for (k = 0; k < kAround; ++k) {
    ring[2 * k] = 4 * kAround + k;
    ring[2 * k + 1] = 4 * kAround + (k + 1) % kAround;
  }
  planish_edit_change_init(&change, sizeof change);
  planish_closest_answers_init(&answers, sizeof answers);
  answers.positions = answered;
  EXPECT(planish_editor_queries(editor, &smooth) == PLANISH_OK);
  smooth_rows = view_of(editor).row_count;
  EXPECT(planish_editor_set_sharp(editor, ring, kAround, &corner, 1, 1, &change) == PLANISH_OK);
  now = view_of(editor);
  EXPECT(change.is_whole && change.row_count == (int64_t)now.row_count);
  EXPECT(now.row_count > smooth_rows && change.vertex_count == 0);
  sharp_rows = now.row_count;
  check_fit(editor);
  memcpy(to, now.points + 3 * moved, sizeof to);
  to[2] += 0.05;
  EXPECT(planish_editor_move(editor, &moved, to, 1, &change) == PLANISH_OK && !change.is_whole);
  check_fit(editor);
  /* The queries of before answer for the surface of before. */
  EXPECT(planish_queries_closest(smooth, to, 1, &answers) == PLANISH_OK);
  away = distance(answered, to);
  EXPECT(away > 0.01 && away < 0.06);
  EXPECT(planish_editor_undo(editor, NULL) == PLANISH_OK && !view_of(editor).can_undo);
  EXPECT_INVALID(planish_editor_set_sharp(editor, absent, 1, NULL, 0, 1, NULL), "have no edge");
  EXPECT_INVALID(planish_editor_set_sharp(editor, NULL, 1, NULL, 0, 1, NULL),
                 "crease_edges is NULL");
  EXPECT_INVALID(planish_editor_set_sharp(editor, ring, 0, &corner, (size_t)-1, 1, NULL),
                 "corner_count");
  EXPECT(planish_editor_set_sharp(NULL, ring, 1, NULL, 0, 1, NULL) == PLANISH_INVALID_ARGUMENT);
  EXPECT(view_of(editor).row_count == sharp_rows);
  EXPECT(planish_editor_set_sharp(editor, ring, kAround, &corner, 1, 0, NULL) == PLANISH_OK);
  EXPECT(view_of(editor).row_count == smooth_rows);
  check_fit(editor);
  planish_queries_free(smooth);
  planish_editor_free(editor);
}

static void test_refusals(void) {
  planish_fit* fit = fit_of(cube(), "progressive");
  planish_fit* loop = NULL;
  planish_options* options = options_with("interpolation", "progressive");
  planish_editor *editor = NULL, *none = NULL;
  const int32_t* found = NULL;
  const double* weights = NULL;
  size_t count = 0;
  const int32_t outside = 8, inside = 3;
  const double to[3] = {0, NAN, 0};
  planish_mesh* mesh = cube();
  EXPECT(planish_editor_create(fit, 7, &none) == PLANISH_INVALID_ARGUMENT);
  EXPECT_INVALID(planish_editor_create(NULL, 2, &none), "fit is NULL");
  EXPECT(planish_editor_create(fit, 2, &editor) == PLANISH_OK);
  EXPECT_INVALID(planish_editor_move(editor, &outside, to, 1, NULL), "no vertex 8");
  EXPECT(planish_last_error_element() == 8);
  EXPECT_INVALID(planish_editor_move(editor, &inside, to, 1, NULL), "vertex 3");
  EXPECT(planish_editor_move(editor, NULL, to, 1, NULL) == PLANISH_INVALID_ARGUMENT);
  EXPECT(planish_editor_move(editor, &inside, NULL, 1, NULL) == PLANISH_INVALID_ARGUMENT);
  EXPECT_INVALID(planish_editor_move(editor, &inside, to, (size_t)-1, NULL), "count");
  EXPECT(planish_editor_transform(editor, &inside, NULL, 1, NULL, NULL) ==
         PLANISH_INVALID_ARGUMENT);
  EXPECT(planish_editor_select(editor, &inside, 1, 0, &found, &weights, &count) ==
         PLANISH_INVALID_ARGUMENT);
  EXPECT(found == NULL && !view_of(editor).can_undo);
  EXPECT(planish_editor_move(NULL, &inside, to, 1, NULL) == PLANISH_INVALID_ARGUMENT);
  EXPECT(planish_editor_move(editor, NULL, NULL, 0, NULL) == PLANISH_OK);
  set(options, "scheme", "catmull-clark");
  set(options, "max_iterations", "1");
  EXPECT(planish_fit_create(mesh, options, &loop) == PLANISH_NOT_CONVERGED);
  EXPECT(planish_editor_create(loop, 2, &none) == PLANISH_INVALID_ARGUMENT && none == NULL);
  planish_editor_free(editor);
  planish_editor_free(NULL);
  planish_options_free(options);
  planish_fit_free(loop);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

int main(void) {
  test_moves("progressive");
  test_moves("fair");
  test_creases("progressive");
  test_creases("fair");
  test_selection();
  test_refusals();
  return failures == 0 ? 0 : 1;
}
