/* The interface for C as a C program sees it: a mesh from arrays and from a file, fit, evaluation,
 * files, and everything that a caller can get wrong. Arguments: an OBJ file by its whole path. */
#define _POSIX_C_SOURCE 200809L /* threads and their clocks, folders */
#include <dirent.h>
#include <math.h>
#include <planish/c/editor.h>
#include <planish/c/planish.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cube.h"

/* Its vertices are hit, its normals have unit length, its faces name its vertices. */
static void check_surface(const planish_surface_arrays* arrays, double tolerance) {
  size_t i;
  for (i = 0; i < arrays->base_count; ++i) {
    const double* p = arrays->positions + 3 * i;
    const double* q = kPositions + 3 * arrays->base_vertices[i];
    EXPECT(fabs(p[0] - q[0]) + fabs(p[1] - q[1]) + fabs(p[2] - q[2]) <= 3 * tolerance);
  }
  for (i = 0; i < arrays->vertex_count; ++i) {
    const float* n = arrays->normals + 3 * i;
    EXPECT(fabs(sqrt((double)(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])) - 1) < 1e-5);
  }
  for (i = 0; i < arrays->corner_count; ++i)
    EXPECT(arrays->face_vertices[i] >= 0 &&
           (size_t)arrays->face_vertices[i] < arrays->vertex_count);
}

static int count_steps(void* user, const char* step, double fraction) {
  EXPECT(step != NULL && fraction >= 0 && fraction <= 1);
  ++*(int*)user;
  return 0;
}

static int cancel(void* user, const char* step, double fraction) {
  (void)user, (void)step, (void)fraction;
  return 1;
}

static void test_fit(void) {
  planish_mesh* mesh = cube();
  planish_fit* fit = NULL;
  planish_surface* surface = NULL;
  planish_options* options = options_with("tolerance", "1e-10");
  planish_fit_info info;
  planish_surface_arrays arrays;
  int steps = 0;
  planish_fit_info_init(&info, sizeof info);
  planish_surface_arrays_init(&arrays, sizeof arrays);
  planish_options_on_progress(options, count_steps, &steps);
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  EXPECT(steps > 0);
  planish_mesh_free(mesh); /* the fit needs it no more */
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK);
  EXPECT(info.converged && info.max_error <= 1e-10 && info.rms_error <= info.max_error);
  EXPECT(info.vertex_count == 8 && info.face_count == 6 && fabs(info.diagonal - sqrt(3.0)) < 1e-15);
  EXPECT(planish_fit_evaluate(fit, PLANISH_LEVEL_AUTO, &surface) == PLANISH_OK);
  EXPECT(planish_surface_view(surface, &arrays) == PLANISH_OK);
  EXPECT(arrays.face_count == 96 && arrays.face_offsets == NULL && arrays.base_count == 8);
  check_surface(&arrays, 1e-10 * sqrt(3.0));
  planish_surface_free(surface);
  planish_options_on_progress(options, cancel, NULL);
  mesh = cube();
  surface = NULL;
  planish_fit_free(fit);
  fit = NULL;
  EXPECT_REFUSED(planish_fit_create(mesh, options, &fit), PLANISH_CANCELLED, "cancelled");
  EXPECT(fit == NULL);
  planish_options_on_progress(options, NULL, NULL);
  set(options, "max_iterations", "1");
  set(options, "interpolation", "progressive");
  EXPECT_REFUSED(planish_fit_create(mesh, options, &fit), PLANISH_NOT_CONVERGED,
                 " of the diagonal after iteration 1, and options.tolerance ");
  EXPECT(fit != NULL && planish_fit_get_info(fit, &info) == PLANISH_OK && !info.converged);
  EXPECT(info.iterations == 1 && strcmp(info.interpolation, "progressive") == 0);
  planish_fit_free(fit);
  planish_options_free(options);
  planish_mesh_free(mesh);
}

/* Two squares, one folded back onto the other. */
static planish_mesh* folded_sheet(void) {
  static const double positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0, 0, 0.5, 1, 0};
  static const int32_t corners[] = {0, 1, 2, 3, 1, 4, 5, 2};
  return made(arrays_of(positions, 6, corners, 2, 4));
}

/* Of the cube's surface, whose vertices are at face corners, after its fit is gone. */
static void test_queries(void) {
  static const planish_place places[] = {{0, 0, 0}, {5, 1, 1}, {2, 0.25, 0.4}};
  static const double points[] = {0, 0, 0, 0.5, 0.5, 9};
  static const double origins[] = {0.5, 0.5, -5, 0.5, 0.5, -5, 0.5, 0.5, -5};
  static const double directions[] = {0, 0, 2, 0, 1, 0, 0, 0, -1};
  double at[9], normals[9], du[9], mean[3], gaussian[3], distances[3], t[3], again[3];
  int32_t has_second[3];
  planish_place found[3];
  planish_mesh *mesh = cube(), *folded = folded_sheet();
  planish_fit *fit, *folded_fit;
  planish_queries* queries = NULL;
  planish_surface *coarse = NULL, *fine = NULL;
  planish_surface_arrays coarse_arrays, fine_arrays;
  planish_options* options = options_with("tolerance", "1e-10");
  planish_place_answers on;
  planish_closest_answers near_to;
  planish_ray_answers hits;
  const char *code = NULL, *message = NULL;
  size_t i;
  planish_place_answers_init(&on, sizeof on);
  planish_closest_answers_init(&near_to, sizeof near_to);
  planish_ray_answers_init(&hits, sizeof hits);
  planish_surface_arrays_init(&coarse_arrays, sizeof coarse_arrays);
  planish_surface_arrays_init(&fine_arrays, sizeof fine_arrays);
  set(options, "threads", "1");
  set(options, "creases", "use");
  fit = fitted(mesh, options);
  EXPECT(planish_fit_tessellate(fit, 1e-2, 0, &coarse) == PLANISH_OK);
  EXPECT(planish_fit_tessellate(fit, 1e-3, 20, &fine) == PLANISH_OK);
  EXPECT(planish_surface_view(coarse, &coarse_arrays) == PLANISH_OK);
  EXPECT(planish_surface_view(fine, &fine_arrays) == PLANISH_OK);
  EXPECT(coarse_arrays.corner_count == 3 * coarse_arrays.face_count);
  EXPECT(coarse_arrays.face_count < fine_arrays.face_count && coarse_arrays.base_count == 8);
  check_surface(&coarse_arrays, 1e-10 * sqrt(3.0));
  EXPECT_INVALID(planish_fit_tessellate(fit, 0, 0, &fine), "chord error");
  EXPECT(planish_surface_warning_count(fine) == 0 && planish_surface_warning_count(NULL) == 0);
  planish_surface_free(coarse);
  planish_surface_free(fine);
  set(options, "interpolation", "progressive");
  folded_fit = fitted(folded, options);
  planish_options_free(options);
  EXPECT(planish_fit_tessellate(folded_fit, 0, 5, &fine) == PLANISH_OK);
  EXPECT(planish_surface_warning_count(fine) == 1);
  EXPECT(planish_surface_warning(fine, 0, &code, &message) == PLANISH_OK);
  EXPECT(strcmp(code, "angle-not-kept") == 0 && strstr(message, "5 degrees") != NULL);
  EXPECT_INVALID(planish_surface_warning(fine, 1, NULL, NULL), "the surface has 1 warnings");
  planish_surface_free(fine);
  planish_fit_free(folded_fit);
  planish_mesh_free(folded);
  EXPECT(planish_queries_create(fit, &queries) == PLANISH_OK);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
  on.positions = at;
  on.normals = normals;
  on.du = du;
  on.mean = mean;
  on.gaussian = gaussian;
  on.has_second = has_second;
  EXPECT(planish_queries_evaluate(queries, places, 3, &on) == PLANISH_OK);
  for (i = 0; i < 3; ++i) {
    EXPECT(fabs(at[i] - kPositions[3 * kCorners[0] + i]) < 1e-9);
    EXPECT(fabs(at[3 + i] - kPositions[3 * kCorners[22] + i]) < 1e-9);
    EXPECT(fabs(du[3 * i] * normals[3 * i] + du[3 * i + 1] * normals[3 * i + 1] +
                du[3 * i + 2] * normals[3 * i + 2]) < 1e-9);
  }
  EXPECT(!has_second[0] && !has_second[1] && has_second[2] && mean[0] == 0);
  EXPECT(mean[2] > 0.1 && gaussian[2] > 0 && gaussian[2] <= mean[2] * mean[2] * (1 + 1e-12));
  near_to.places = found;
  near_to.positions = at;
  near_to.distances = distances;
  EXPECT(planish_queries_closest(queries, points, 2, &near_to) == PLANISH_OK);
  EXPECT(distances[0] < 1e-9 && fabs(distances[1] - (9 - at[5])) < 1e-12 && at[5] > 1);
  on.mean = on.gaussian = on.du = NULL;
  on.positions = again;
  EXPECT(planish_queries_evaluate(queries, found + 1, 1, &on) == PLANISH_OK);
  for (i = 0; i < 3; ++i) EXPECT(fabs(again[i] - at[3 + i]) < 1e-12);
  hits.places = found;
  hits.positions = at;
  hits.t = t;
  EXPECT(planish_queries_first_hit(queries, origins, directions, 3, 0, 1e300, &hits) == PLANISH_OK);
  EXPECT(found[0].face >= 0 && found[1].face == -1 && found[2].face == -1);
  EXPECT(fabs(at[2] - (2 * t[0] - 5)) < 1e-12 && at[2] < 0 && fabs(at[0] - 0.5) < 1e-12);
  EXPECT(planish_queries_first_hit(queries, origins, directions, 1, 0, t[0] / 2, &hits) ==
         PLANISH_OK);
  EXPECT(found[0].face == -1);
  planish_queries_free(queries);
}

static void test_wrong_queries(void) {
  static const planish_place outside = {0, 1.5, 0}, nowhere = {6, 0, 0};
  static const double nothing[3] = {0, 0, 0};
  planish_mesh* mesh = cube();
  planish_fit* fit = NULL;
  planish_queries *queries = NULL, *none = NULL;
  planish_options* options = options_with("scheme", "catmull-clark");
  planish_place_answers on;
  planish_closest_answers near_to;
  planish_ray_answers hits;
  double at[3] = {7, 7, 7}, no_number[3] = {0, 0, 0};
  planish_place_answers_init(&on, sizeof on);
  planish_closest_answers_init(&near_to, sizeof near_to);
  planish_ray_answers_init(&hits, sizeof hits);
  on.positions = near_to.positions = hits.positions = at;
  no_number[1] = NAN;
  EXPECT(planish_fit_create(mesh, NULL, &fit) == PLANISH_OK);
  EXPECT(planish_queries_create(fit, &queries) == PLANISH_OK);
  EXPECT_INVALID(planish_queries_create(fit, NULL), "queries is NULL");
  EXPECT_INVALID(planish_queries_create(NULL, &none), "fit is NULL");
  EXPECT_INVALID(planish_queries_evaluate(queries, &outside, 1, &on), "1.5");
  EXPECT_INVALID(planish_queries_evaluate(queries, &nowhere, 1, &on), "6");
  EXPECT_INVALID(planish_queries_evaluate(queries, NULL, 1, &on), "places is NULL");
  EXPECT_INVALID(planish_queries_evaluate(queries, &outside, 1, NULL), "answers is NULL");
  EXPECT_INVALID(planish_queries_closest(queries, no_number, 1, &near_to), "point");
  EXPECT_INVALID(planish_queries_closest(queries, nothing, (size_t)-1, &near_to), "2^31");
  EXPECT_INVALID(planish_queries_first_hit(queries, nothing, nothing, 1, 0, 1, &hits), "direction");
  near_to.struct_size = 1;
  EXPECT_INVALID(planish_queries_closest(queries, nothing, 1, &near_to), "struct_size is 1");
  EXPECT(at[0] == 7 && at[1] == 7 && at[2] == 7);
  EXPECT(planish_queries_closest(queries, NULL, 0, NULL) == PLANISH_INVALID_ARGUMENT);
  planish_queries_free(queries);
  planish_queries_free(NULL);
  planish_fit_free(fit);
  fit = NULL;
  set(options, "max_iterations", "2");
  EXPECT(planish_fit_create(mesh, options, &fit) != PLANISH_INVALID_ARGUMENT);
  EXPECT_INVALID(planish_queries_create(fit, &none), "take options.scheme doo-sabin");
  planish_options_free(options);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

static void test_verify(void) {
  planish_mesh* mesh = cube();
  planish_mesh* cage = NULL;
  planish_fit* fit = NULL;
  planish_mesh_arrays view;
  planish_verification found;
  planish_options* options = options_with("interpolation", "progressive");
  planish_mesh_arrays_init(&view, sizeof view);
  planish_verification_init(&found, sizeof found);
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  planish_options_free(options);
  EXPECT(planish_fit_cage(fit, &cage) == PLANISH_OK);
  EXPECT(planish_verify(cage, mesh, NULL, &found) == PLANISH_OK);
  EXPECT(found.confirmed && found.vertex_count == 8 && found.max_error <= 1e-6);
  EXPECT(planish_verify(mesh, mesh, NULL, &found) == PLANISH_OK);
  EXPECT(!found.confirmed && found.max_error > 0.01);
  EXPECT(planish_mesh_view(cage, &view) == PLANISH_OK);
  EXPECT(view.vertex_count == 8 && view.face_count == 6 && view.corner_count == 24);
  EXPECT(view.face_sizes[5] == 4 && memcmp(view.face_vertices, kCorners, sizeof kCorners) == 0);
  EXPECT(view.positions[0] < 0); /* control points lie outside */
  planish_fit_free(fit);
  planish_mesh_free(cage);
  planish_mesh_free(mesh);
}

/* What was found to be sharp is handed on to who verifies, who looks for nothing then. */
static void test_verify_sharp(void) {
  planish_mesh *mesh = cube(), *cage = NULL;
  planish_fit* fit = NULL;
  planish_options* options = options_with("interpolation", "fair");
  planish_verification found;
  const int32_t *edges = NULL, *corners = NULL;
  size_t edge_count = 0, corner_count = 0;
  planish_verification_init(&found, sizeof found);
  set(options, "creases", "auto");
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  EXPECT(planish_fit_sharp(fit, &edges, &edge_count, &corners, &corner_count) == PLANISH_OK);
  EXPECT(edge_count == 12);
  EXPECT(planish_fit_cage(fit, &cage) == PLANISH_OK);
  EXPECT(planish_verify(cage, mesh, options, &found) == PLANISH_OK && found.confirmed);
  set(options, "creases", "use");
  EXPECT_REFUSED(planish_verify(cage, mesh, options, &found), PLANISH_UNUSABLE_MESH,
                 "54 faces for 26");
  EXPECT(planish_options_set_sharp(options, edges, edge_count, corners, corner_count) ==
         PLANISH_OK);
  planish_fit_free(fit);
  EXPECT(planish_verify(cage, mesh, options, &found) == PLANISH_OK && found.confirmed);
  EXPECT(planish_options_set_sharp(options, NULL, 0, NULL, 0) == PLANISH_OK);
  EXPECT_REFUSED(planish_verify(cage, mesh, options, &found), PLANISH_UNUSABLE_MESH,
                 "54 faces for 26");
  planish_options_free(options);
  planish_mesh_free(cage);
  planish_mesh_free(mesh);
}

/* An open cage is of its weights and its rule of boundaries: verified with these alone. */
static void test_verify_shapes(void) {
  static const double positions[] = {0,   0, 0, 1,   0, 0.3, 2, 0, 0, 0,   1, 0.2, 1, 1,
                                     0.6, 2, 1, 0.1, 0, 2,   0, 1, 2, 0.4, 2, 2,   0};
  static const int32_t corners[] = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4,
                                    3, 4, 7, 3, 7, 6, 4, 5, 8, 4, 8, 7};
  planish_mesh *mesh = made(arrays_of(positions, 9, corners, 8, 3)), *cage = NULL;
  planish_fit* fit = NULL;
  static const char *const weights[] = {"doo-sabin", "averaged"}, *const boundaries[] = {
                                                                      "edge", "edge-and-corner"};
  planish_options *options = NULL, *other = NULL;
  planish_fit_info info;
  planish_verification found;
  const int32_t *sharp_edges = NULL, *sharp_corners = NULL;
  size_t edge_count = 7, corner_count = 7;
  int w, b, other_w, other_b;
  planish_verification_init(&found, sizeof found);
  for (w = 0; w < 2; ++w) {
    for (b = 0; b < 2; ++b) {
      options = options_with("interpolation", "progressive");
      set(options, "weights", weights[w]);
      set(options, "boundary", boundaries[b]);
      set(options, "quads", "off"); /* on quads both weights are one */
      fit = fitted(mesh, options);
      EXPECT(planish_fit_cage(fit, &cage) == PLANISH_OK);
      EXPECT(planish_fit_sharp(fit, &sharp_edges, &edge_count, &sharp_corners, &corner_count) ==
             PLANISH_OK);
      EXPECT(edge_count == 0 && corner_count == 0 && sharp_edges != NULL && sharp_corners != NULL);
      for (other_w = 0; other_w < 2; ++other_w) {
        for (other_b = 0; other_b < 2; ++other_b) {
          other = options_with("quads", "off");
          set(other, "weights", weights[other_w]);
          set(other, "boundary", boundaries[other_b]);
          EXPECT(planish_verify(cage, mesh, other, &found) == PLANISH_OK);
          EXPECT(found.confirmed == (other_w == w && other_b == b));
          planish_options_free(other);
        }
      }
      planish_options_free(options);
      planish_mesh_free(cage);
      planish_fit_free(fit);
    }
  }
  options = options_with("interpolation", "progressive");
  set(options, "quads", "on");
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  planish_fit_info_init(&info, sizeof info);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK && info.face_count == 4);
  EXPECT(planish_fit_cage(fit, &cage) == PLANISH_OK);
  EXPECT(planish_verify(cage, mesh, options, &found) == PLANISH_OK && found.confirmed);
  EXPECT(planish_verify(cage, mesh, NULL, &found) == PLANISH_OK && found.confirmed);
  set(options, "quads", "off");
  EXPECT_REFUSED(planish_verify(cage, mesh, options, &found), PLANISH_UNUSABLE_MESH,
                 "4 faces for 8");
  planish_options_free(options);
  planish_mesh_free(cage);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

static size_t fitted_vertices(planish_mesh* mesh, const planish_options* options) {
  planish_fit* fit = fitted(mesh, options);
  planish_fit_info info;
  planish_fit_info_init(&info, sizeof info);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK);
  planish_fit_free(fit);
  return info.vertex_count;
}

/* Two triangles that almost share two vertices. */
static void test_weld(void) {
  static const double positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1e-7, 0, 1, 1, 0, 1e-7, 1, 0};
  static const double equal[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  static const int32_t corners[] = {0, 1, 2, 3, 4, 5}, sizes[] = {3, 3};
  planish_mesh_arrays arrays = arrays_of(positions, 6, corners, 2, 3);
  planish_options* options = options_with("weld", "1e-6");
  planish_mesh* mesh = NULL;
  arrays.face_sizes = sizes;
  mesh = made(arrays);
  EXPECT(fitted_vertices(mesh, NULL) == 6 && fitted_vertices(mesh, options) == 4);
  set(options, "weld", "0"); /* equal positions: there are none */
  EXPECT(fitted_vertices(mesh, options) == 6);
  planish_mesh_free(mesh);
  mesh = made(arrays_of(equal, 6, corners, 2, 3));
  EXPECT_INVALID(planish_options_set(options, "weld", "0.5"), "weld");
  EXPECT(fitted_vertices(mesh, options) == 4); /* 0 stays */
  planish_options_free(options);
  planish_mesh_free(mesh);
}

static void test_reader_warnings(void) {
  const char *found = NULL, *message = NULL;
  planish_mesh* mesh = NULL;
  FILE* file = fopen("odd.ply", "w");
  EXPECT(file != NULL);
  fputs(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0 7\n0 1 0\n3 0 1 2\n",
      file);
  fclose(file);
  EXPECT(planish_mesh_read("odd.ply", &mesh) == PLANISH_OK);
  EXPECT(planish_mesh_warning_count(mesh) == 1);
  EXPECT(planish_mesh_warning(mesh, 0, &found, &message) == PLANISH_OK);
  EXPECT(found != NULL && message != NULL && strstr(message, "odd.ply:11") != NULL);
  EXPECT(planish_mesh_warning(mesh, 0, NULL, NULL) == PLANISH_OK);
  EXPECT_INVALID(planish_mesh_warning(mesh, 1, &found, &message), "index is 1");
  EXPECT(planish_mesh_warning_count(NULL) == 0);
  planish_mesh_free(mesh);
}

/* Whether a file holds a text without zeros. */
static int file_has(const char* path, const char* text) {
  static char bytes[1 << 16];
  FILE* file = fopen(path, "rb");
  if (file == NULL) return 0;
  const size_t count = fread(bytes, 1, sizeof bytes, file), length = strlen(text);
  fclose(file);
  for (size_t i = 0; i + length <= count; ++i)
    if (memcmp(bytes + i, text, length) == 0) return 1;
  return 0;
}

static void test_step(const char* input) {
  planish_mesh* mesh = NULL;
  planish_fit* fit = NULL;
  planish_editor* editor = NULL;
  planish_options* options = options_with("step_unit", "in");
  EXPECT(planish_mesh_read(input, &mesh) == PLANISH_OK);
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  EXPECT(planish_fit_write(fit, 1, "a.step") == PLANISH_OK);
  EXPECT(file_has("a.step", "'INCH'"));
  /* What is moved by an editor is written likewise. */
  EXPECT(planish_editor_create(fit, 1, &editor) == PLANISH_OK);
  planish_fit_free(fit);
  EXPECT(planish_editor_fit(editor, &fit) == PLANISH_OK);
  EXPECT(planish_fit_write(fit, 1, "b.step") == PLANISH_OK && file_has("b.step", "'INCH'"));
  planish_editor_free(editor);
  planish_fit_free(fit);
  fit = NULL;
  /* A fit keeps what it was made with. */
  set(options, "step_tolerance", "1e-30");
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  EXPECT_REFUSED(planish_fit_write(fit, 1, "a.step"), PLANISH_NOT_CONVERGED,
                 "faces leave the surface by up to");
  EXPECT_REFUSED(planish_fit_file(input, "a.step", options, NULL), PLANISH_NOT_CONVERGED,
                 "options.step_tolerance");
  planish_fit_free(fit);
  planish_options_free(options);
  planish_mesh_free(mesh);
}

static void test_files(const char* input) {
  planish_mesh* mesh = NULL;
  planish_fit* fit = NULL;
  planish_fit_info info;
  planish_fit_info_init(&info, sizeof info);
  EXPECT(planish_mesh_read(input, &mesh) == PLANISH_OK);
  EXPECT(planish_fit_create(mesh, NULL, &fit) == PLANISH_OK);
  EXPECT(planish_fit_write(fit, 1, "a.glb") == PLANISH_OK);
  EXPECT(planish_mesh_write(mesh, "mesh.ply") == PLANISH_OK);
  EXPECT(planish_fit_file(input, "file.glb", NULL, &info) == PLANISH_OK);
  EXPECT(info.converged && info.vertex_count > 100);
  EXPECT(planish_mesh_warning_count(mesh) == 0);
  EXPECT_REFUSED(planish_mesh_read("none.obj", &mesh), PLANISH_UNREADABLE_INPUT, "none.obj");
  EXPECT_REFUSED(planish_fit_write(fit, 1, "none/a.glb"), PLANISH_UNWRITABLE_OUTPUT, "none");
  EXPECT_INVALID(planish_fit_write(fit, 1, "a.iges"), ".glb");
  EXPECT_INVALID(planish_fit_write(fit, 7, "a.glb"), "7");
  EXPECT_INVALID(planish_mesh_write(mesh, "a.glb"), ".obj");
  EXPECT_INVALID(planish_fit_file(input, input, NULL, NULL), "itself");
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

static void put_file(const char* path, const char* text) {
  FILE* file = fopen(path, "w");
  EXPECT(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void test_named_files(void) {
  planish_options* options = options_with("levels", "1");
  put_file("y.mtl", "newmtl wood\n# mine\nKd 0.5 0 0\n");
  put_file("x.obj", "mtllib y.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl wood\nf 1 2 3 4\n");
  EXPECT_INVALID(planish_fit_file("x.obj", "y.obj", NULL, NULL),
                 "y.mtl is read with the input x.obj");
  planish_mesh *mesh = NULL, *cage = NULL;
  planish_fit* fit = NULL;
  planish_editor* editor = NULL;
  EXPECT(planish_mesh_read("x.obj", &mesh) == PLANISH_OK);
  EXPECT(planish_fit_create(mesh, NULL, &fit) == PLANISH_OK);
  EXPECT(planish_fit_cage(fit, &cage) == PLANISH_OK);
  EXPECT_INVALID(planish_mesh_write(mesh, "x.obj"), "the input itself");
  EXPECT_INVALID(planish_mesh_write(mesh, "y.obj"), "y.mtl is read with");
  EXPECT_INVALID(planish_mesh_write(cage, "y.obj"), "y.mtl is read with");
  EXPECT_INVALID(planish_fit_write(fit, 1, "y.obj"), "y.mtl is read with");
  EXPECT(planish_editor_create(fit, 1, &editor) == PLANISH_OK);
  planish_fit_free(fit);
  EXPECT(planish_editor_fit(editor, &fit) == PLANISH_OK);
  EXPECT_INVALID(planish_fit_write(fit, 1, "y.obj"), "y.mtl is read with");
  EXPECT(planish_mesh_write(mesh, "z.obj") == PLANISH_OK);
  planish_editor_free(editor);
  planish_fit_free(fit);
  planish_mesh_free(cage);
  planish_mesh_free(mesh);
  EXPECT(file_has("y.mtl", "# mine"));
  planish_options_free(options);
}

static void test_levels_of_detail(const char* input) {
  planish_options* options = options_with("levels", "0");
  EXPECT(planish_fit_file(input, "whole.glb", options, NULL) == PLANISH_OK);
  set(options, "levels", "1");
  EXPECT(planish_fit_file("whole.glb", "one.glb", options, NULL) == PLANISH_OK);
  EXPECT(!file_has("one.glb", "MSFT_lod"));
  set(options, "levels", "0,1");
  EXPECT_INVALID(planish_fit_file("whole.glb", "lods.glb", options, NULL),
                 "options.levels: several are a file each; take one, or options.lods msft");
  set(options, "lods", "msft");
  EXPECT(planish_fit_file("whole.glb", "lods.glb", options, NULL) == PLANISH_OK);
  EXPECT(file_has("lods.glb", "MSFT_lod"));
  EXPECT_INVALID(planish_fit_file(input, "no.glb", options, NULL), "take --lods files");
  planish_options_free(options);
}

/* The option is the level that is not named, of fits and of their editors. */
static void test_level_not_named(void) {
  planish_mesh* mesh = cube();
  planish_options* options = options_with("levels", "1");
  planish_fit* fit = NULL;
  planish_editor* editor = NULL;
  planish_surface* surface = NULL;
  planish_surface_arrays arrays;
  planish_editor_arrays rows;
  planish_surface_arrays_init(&arrays, sizeof arrays);
  planish_editor_arrays_init(&rows, sizeof rows);
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  EXPECT(planish_fit_evaluate(fit, PLANISH_LEVEL_AUTO, &surface) == PLANISH_OK);
  EXPECT(planish_surface_view(surface, &arrays) == PLANISH_OK && arrays.face_count == 24);
  EXPECT(planish_editor_create(fit, PLANISH_LEVEL_AUTO, &editor) == PLANISH_OK);
  EXPECT(planish_editor_view(editor, &rows) == PLANISH_OK);
  EXPECT(rows.row_count == arrays.vertex_count);
  planish_editor_free(editor);
  planish_surface_free(surface);
  planish_fit_free(fit);
  planish_options_free(options);
  planish_mesh_free(mesh);
}

static void test_wrong_meshes(void) {
  planish_mesh_arrays arrays = cube_arrays();
  planish_mesh* mesh = NULL;
  static const int32_t bad_corners[] = {0, 2, 3, 8}, negative_size[] = {4, -4, 4, 4, 4, 4},
                       creases[] = {0, 8};
  EXPECT_INVALID(planish_mesh_create(NULL, &mesh), "arrays is NULL");
  EXPECT_INVALID(planish_mesh_create(&arrays, NULL), "mesh is NULL");
  arrays.struct_size = 0;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "struct_size is 0");
  arrays = cube_arrays();
  arrays.positions = NULL;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "positions is NULL");
  arrays = cube_arrays();
  arrays.corner_count = 23;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "face 5 has 4");
  arrays.corner_count = 25;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "corner_count is 25");
  arrays = cube_arrays();
  arrays.corners_per_face = 0;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "corners_per_face");
  arrays = cube_arrays();
  arrays.face_sizes = negative_size;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "face 1 has -4");
  arrays = cube_arrays();
  arrays.face_count = (size_t)-1;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "face_count");
  arrays = cube_arrays();
  arrays.vertex_count = (size_t)1 << 40;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "2^31");
  arrays = cube_arrays();
  arrays.face_vertices = bad_corners;
  arrays.face_count = 1;
  arrays.corner_count = 4;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_UNUSABLE_MESH, "names vertex 8 of 8");
  EXPECT(planish_last_error_element() == 0);
  arrays = cube_arrays();
  arrays.crease_edges = creases;
  arrays.crease_count = 1;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_UNUSABLE_MESH, "crease 0");
  EXPECT(mesh == NULL);
}

/* Each by itself where it is set. */
static void test_wrong_values(void) {
  static const struct {
    const char *name, *value, *words;
  } rows[] = {
      {"tolerance", "-1", "-1 is out of range; "},
      {"interpolation", "best", "\"best\" is not one of auto, progressive, fair"},
      {"creases", "auto:-1", "\"-1\" is no angle of 0 to 180 degrees"},
      {"creases", "auto:181", "\"181\" is no angle of 0 to 180 degrees"},
      {"weights", "even", "\"even\" is not one of doo-sabin, averaged"},
      {"polish", "1001", "1001 is out of range; 0 to 1000 is wanted"},
      {"quads", "yes", "\"yes\" is not one of auto, on, off"},
      {"weld", "-1", "-1 is out of range; 0, or a fraction"},
      {"step_tolerance", "0", ""},
      {"step_unit", "inch", "\"inch\" is not one of mm, cm, m, in, auto"},
      {"levels", "1,1", "level 1 is named twice"},
      {"levels", "7", "7 is out of range; levels are 0 to 6"},
  };
  planish_options* options = options_with("levels", "1");
  char begin[64];
  size_t i;
  for (i = 0; i < sizeof rows / sizeof *rows; ++i) {
    EXPECT_INVALID(planish_options_set(options, rows[i].name, rows[i].value), rows[i].words);
    sprintf(begin, "options.%s: ", rows[i].name);
    EXPECT(strncmp(planish_last_error(), begin, strlen(begin)) == 0);
  }
  planish_options_free(options);
}

static void test_wrong_options(void) {
  planish_mesh* mesh = cube();
  planish_mesh_arrays nothing;
  planish_mesh* empty = NULL;
  planish_fit* fit = NULL;
  planish_options* options = options_with("weights", "averaged");
  planish_fit_info info;
  EXPECT_INVALID(planish_fit_create(NULL, NULL, &fit), "mesh is NULL");
  EXPECT_INVALID(planish_fit_create(mesh, NULL, NULL), "fit is NULL");
  EXPECT_INVALID(planish_fit_get_info(NULL, &info), "fit is NULL");
  EXPECT_INVALID(planish_fit_file(NULL, "a.glb", NULL, NULL), "input");
  EXPECT_INVALID(planish_verify(mesh, mesh, NULL, NULL), "is NULL");
  EXPECT_INVALID(planish_fit_file("a.obj", NULL, NULL, NULL), "output");
  /* All together where they are used. */
  set(options, "scheme", "catmull-clark");
  EXPECT_INVALID(planish_fit_create(mesh, options, &fit),
                 "options.weights: averaged belongs to options.scheme doo-sabin");
  EXPECT_INVALID(planish_fit_file("a.obj", "a.glb", options, NULL),
                 "options.weights: averaged belongs to options.scheme doo-sabin");
  set(options, "weights", "doo-sabin");
  set(options, "quads", "on");
  set(options, "scheme", "loop");
  EXPECT_INVALID(planish_fit_create(mesh, options, &fit),
                 "options.quads: loop surfaces are of triangles; take off");
  set(options, "quads", "auto");
  set(options, "interpolation", "fair");
  EXPECT_INVALID(planish_fit_create(mesh, options, &fit), "options.interpolation: fair builds");
  set(options, "scheme", "doo-sabin");
  set(options, "creases", "normals");
  EXPECT_INVALID(planish_fit_create(mesh, options, &fit),
                 "options.creases: normals are a file's; take planish_fit_file()");
  EXPECT_INVALID(planish_options_set_sharp(options, NULL, 0, NULL, 1), "corners is NULL");
  EXPECT_INVALID(planish_options_set_sharp(options, kCorners, (size_t)1 << 40, NULL, 0),
                 "edge_count is 1099511627776");
  planish_options_free(options);
  planish_mesh_arrays_init(&nothing, sizeof nothing);
  EXPECT(planish_mesh_create(&nothing, &empty) == PLANISH_OK);
  EXPECT_REFUSED(planish_fit_create(empty, NULL, &fit), PLANISH_UNUSABLE_MESH, "mesh");
  EXPECT(fit == NULL);
  planish_mesh_free(empty);
  planish_mesh_free(mesh);
  planish_mesh_free(NULL);
  planish_fit_free(NULL);
  planish_surface_free(NULL);
}

/* Callers whose headers ended behind `iterations`, and behind the mesh's `corner_count`. */
static void test_older_structs(void) {
  planish_mesh* mesh = NULL;
  planish_fit* fit = NULL;
  planish_fit_info info;
  planish_mesh_arrays arrays = cube_arrays();
  memset(&arrays.crease_edges, 0xff, sizeof arrays - offsetof(planish_mesh_arrays, crease_edges));
  arrays.struct_size = offsetof(planish_mesh_arrays, crease_edges);
  EXPECT(planish_mesh_create(&arrays, &mesh) == PLANISH_OK);
  EXPECT(planish_fit_create(mesh, NULL, &fit) == PLANISH_OK);
  memset(&info, 0x5a, sizeof info);
  planish_fit_info_init(&info, offsetof(planish_fit_info, max_error));
  EXPECT(info.struct_size == offsetof(planish_fit_info, max_error) && info.max_error > 1e100);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK);
  EXPECT(info.converged == 1 && info.max_error > 1e100);
  EXPECT(info.struct_size == offsetof(planish_fit_info, max_error));
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

/* A grid of side x side quads, as a file and as a handle. */
static planish_mesh* bumpy_grid(int side) {
  const size_t row = (size_t)side + 1, count = (size_t)side * (size_t)side;
  double* positions = malloc(3 * row * row * sizeof *positions);
  int32_t* corners = malloc(4 * count * sizeof *corners);
  planish_mesh* mesh = NULL;
  size_t i, j;
  for (j = 0; j < row; ++j) {
    for (i = 0; i < row; ++i) {
      double* p = positions + 3 * (j * row + i);
      p[0] = (double)i, p[1] = (double)j,
      p[2] = 0.1 * side * sin(9.0 * i / side) * cos(7.0 * j / side);
    }
  }
  for (j = 0; j + 1 < row; ++j) {
    for (i = 0; i + 1 < row; ++i) {
      int32_t* c = corners + 4 * (j * (size_t)side + i);
      c[0] = (int32_t)(j * row + i), c[1] = c[0] + 1;
      c[3] = (int32_t)((j + 1) * row + i), c[2] = c[3] + 1;
    }
  }
  mesh = made(arrays_of(positions, row * row, corners, count, 4));
  free(positions);
  free(corners);
  return mesh;
}

/* A host that bears calls on its own thread alone, one at a time, whose fractions rise. */
typedef struct host {
  pthread_t thread;
  int inside, is_wronged, calls;
  double last;
} host;

static int watch(void* user, const char* step, double fraction) {
  host* self = user;
  (void)step;
  if (!pthread_equal(pthread_self(), self->thread) || self->inside != 0 || fraction < self->last ||
      fraction > 1)
    self->is_wronged = 1;
  self->inside = 1;
  self->last = fraction;
  ++self->calls;
  self->inside = 0;
  return 0;
}

static void test_callbacks(void) {
  static const char* const names[] = {"host.glb", "host.ply", "host.stl"};
  planish_mesh* mesh = bumpy_grid(250);
  static const char* const methods[] = {"progressive", "fair", "auto"};
  planish_options* options = options_with("levels", "2");
  size_t i;
  EXPECT(planish_mesh_write(mesh, "host.obj") == PLANISH_OK);
  for (i = 0; i < sizeof methods / sizeof *methods; ++i) {
    host self = {0};
    self.thread = pthread_self();
    planish_options_on_progress(options, watch, &self);
    set(options, "interpolation", methods[i]);
    planish_fit_free(fitted(mesh, options));
    EXPECT(!self.is_wronged && self.last == 1 && self.calls > 5);
  }
  for (i = 0; i < sizeof names / sizeof *names; ++i) {
    host self = {0};
    self.thread = pthread_self();
    planish_options_on_progress(options, watch, &self);
    EXPECT(planish_fit_file("host.obj", names[i], options, NULL) == PLANISH_OK);
    EXPECT(!self.is_wronged && self.last == 1 && self.calls > 10);
    remove(names[i]);
  }
  remove("host.obj");
  planish_options_free(options);
  planish_mesh_free(mesh);
}

static double seconds_of(clockid_t clock) {
  struct timespec time;
  clock_gettime(clock, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

typedef struct work {
  planish_mesh* mesh;
  planish_fit* fit;
  planish_queries* queries;
  planish_options* options;
  double* points;
  size_t count;
} work;

static void do_create(work* on) { planish_fit_free(fitted(on->mesh, on->options)); }
static void do_file(work* on) {
  EXPECT(planish_fit_file("one.obj", "one.glb", on->options, NULL) == PLANISH_OK);
}
static void do_write(work* on) { EXPECT(planish_fit_write(on->fit, 2, "one.ply") == PLANISH_OK); }
static void do_evaluate(work* on) {
  planish_surface* surface = NULL;
  EXPECT(planish_fit_evaluate(on->fit, 3, &surface) == PLANISH_OK);
  planish_surface_free(surface);
}
static void do_tessellate(work* on) {
  planish_surface* surface = NULL;
  EXPECT(planish_fit_tessellate(on->fit, 1e-3, 0, &surface) == PLANISH_OK);
  planish_surface_free(surface);
}
static void do_verify(work* on) {
  planish_mesh* cage = NULL;
  planish_verification found;
  planish_verification_init(&found, sizeof found);
  EXPECT(planish_fit_cage(on->fit, &cage) == PLANISH_OK);
  EXPECT(planish_verify(cage, on->mesh, on->options, &found) == PLANISH_OK && found.confirmed);
  planish_mesh_free(cage);
}
static void do_queries(work* on) {
  planish_closest_answers answers;
  double* distances = malloc(on->count * sizeof *distances);
  planish_queries* queries = NULL;
  planish_closest_answers_init(&answers, sizeof answers);
  answers.distances = distances;
  EXPECT(planish_queries_create(on->fit, &queries) == PLANISH_OK);
  EXPECT(planish_queries_closest(queries, on->points, on->count, &answers) == PLANISH_OK);
  planish_queries_free(queries);
  free(distances);
}

/* Of the processor's time hardly any is other threads' where one is allowed. */
static void test_one_thread(void) {
  static void (*const jobs[])(work*) = {do_create,     do_file,   do_write,  do_evaluate,
                                        do_tessellate, do_verify, do_queries};
  work on = {0};
  size_t i;
  int attempt;
  on.mesh = bumpy_grid(120);
  on.options = options_with("threads", "1");
  set(on.options, "levels", "2");
  set(on.options, "interpolation", "progressive");
  EXPECT(planish_mesh_write(on.mesh, "one.obj") == PLANISH_OK);
  on.fit = fitted(on.mesh, on.options);
  on.count = 500;
  on.points = malloc(3 * on.count * sizeof *on.points);
  for (i = 0; i < 3 * on.count; ++i) on.points[i] = (double)(i % 119);
  for (i = 0; i < sizeof jobs / sizeof *jobs; ++i) {
    double share = 1;
    /* Threads that have just worked look for more for a moment. */
    for (attempt = 0; attempt < 5 && share > 0.05; ++attempt) {
      const double process = seconds_of(CLOCK_PROCESS_CPUTIME_ID),
                   thread = seconds_of(CLOCK_THREAD_CPUTIME_ID);
      double own;
      jobs[i](&on);
      own = seconds_of(CLOCK_THREAD_CPUTIME_ID) - thread;
      share = (seconds_of(CLOCK_PROCESS_CPUTIME_ID) - process - own) / own;
    }
    if (share > 0.05) fprintf(stderr, "job %lu: others took %g\n", (unsigned long)i, share);
    EXPECT(share <= 0.05);
  }
  remove("one.obj"), remove("one.glb"), remove("one.ply");
  free(on.points);
  planish_options_free(on.options);
  planish_fit_free(on.fit);
  planish_mesh_free(on.mesh);
}

// README begins
static planish_status print_surface(const char* path) {
  planish_mesh* mesh = NULL;
  planish_options* options = NULL;
  planish_fit* fit = NULL;
  planish_surface* surface = NULL;
  planish_surface_arrays arrays;
  planish_status status = planish_mesh_read(path, &mesh);
  planish_surface_arrays_init(&arrays, sizeof arrays);
  if (status == PLANISH_OK) status = planish_options_create(&options);
  if (status == PLANISH_OK) status = planish_options_set(options, "creases", "auto:40");
  if (status == PLANISH_OK) status = planish_fit_create(mesh, options, &fit);
  if (status == PLANISH_OK) status = planish_fit_evaluate(fit, 2, &surface);
  if (status == PLANISH_OK) status = planish_surface_view(surface, &arrays);
  if (status != PLANISH_OK) fprintf(stderr, "%s\n", planish_last_error());
  printf("%lu vertices\n", (unsigned long)arrays.vertex_count);
  planish_surface_free(surface);
  planish_fit_free(fit);
  planish_options_free(options);
  planish_mesh_free(mesh);
  return status;
}
// README ends

/* The current one, where all files of the tests are. */
static void remove_folder(const char* folder) {
  DIR* entries = opendir(".");
  const struct dirent* entry = NULL;
  EXPECT(entries != NULL);
  while (entries != NULL && (entry = readdir(entries)) != NULL)
    if (entry->d_name[0] != '.') EXPECT(unlink(entry->d_name) == 0);
  if (entries != NULL) closedir(entries);
  EXPECT(chdir("/") == 0 && rmdir(folder) == 0);
}

int main(int argc, char** argv) {
  char folder[] = "/tmp/planish-c-XXXXXX";
  if (argc != 2 || argv[1][0] != '/' || mkdtemp(folder) == NULL || chdir(folder) != 0) return 2;
  EXPECT(strcmp(planish_last_error(), "") == 0 && planish_last_error_element() == -1);
  EXPECT(strchr(planish_version(), '.') != NULL);
  EXPECT(print_surface(argv[1]) == PLANISH_OK);
  test_fit();
  test_callbacks();
  test_one_thread();
  test_verify();
  test_verify_sharp();
  test_verify_shapes();
  test_weld();
  test_reader_warnings();
  test_named_files();
  test_levels_of_detail(argv[1]);
  test_level_not_named();
  test_files(argv[1]);
  test_step(argv[1]);
  test_wrong_meshes();
  test_wrong_values();
  test_wrong_options();
  test_older_structs();
  test_queries();
  test_wrong_queries();
  remove_folder(folder);
  printf("planish %s: %d failures\n", planish_version(), failures);
  return failures == 0 ? 0 : 1;
}
