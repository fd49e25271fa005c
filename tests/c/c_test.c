/* The interface for C as a C program sees it: a mesh from arrays and from a file, fit, evaluation,
 * files, and everything that a caller can get wrong. Arguments: an OBJ file. */
#include <math.h>
#include <planish/c/planish.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

static void expect(int holds, const char* what, int line) {
  if (holds) return;
  ++failures;
  fprintf(stderr, "c_test.c:%d: %s; last error: %s\n", line, what, planish_last_error());
}
#define EXPECT(condition) expect(condition, #condition, __LINE__)
#define EXPECT_REFUSED(call, status, words) expect_refused(call, status, words, #call, __LINE__)

static void expect_refused(planish_status given, planish_status wanted, const char* words,
                           const char* what, int line) {
  expect(given == wanted, what, line);
  expect(strstr(planish_last_error(), words) != NULL, words, line);
}

static const double kPositions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                    0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const int32_t kCorners[] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                                   2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};

static planish_mesh_arrays cube_arrays(void) {
  planish_mesh_arrays arrays;
  planish_mesh_arrays_init(&arrays, sizeof arrays);
  arrays.positions = kPositions;
  arrays.vertex_count = 8;
  arrays.face_count = 6;
  arrays.corners_per_face = 4;
  arrays.face_vertices = kCorners;
  arrays.corner_count = 24;
  return arrays;
}

static planish_mesh* cube(void) {
  const planish_mesh_arrays arrays = cube_arrays();
  planish_mesh* mesh = NULL;
  EXPECT(planish_mesh_create(&arrays, &mesh) == PLANISH_OK);
  return mesh;
}

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
  planish_fit_options options;
  planish_fit_info info;
  planish_surface_arrays arrays;
  int steps = 0;
  planish_fit_options_init(&options, sizeof options);
  planish_fit_info_init(&info, sizeof info);
  planish_surface_arrays_init(&arrays, sizeof arrays);
  options.tolerance = 1e-10;
  options.progress = count_steps;
  options.user = &steps;
  EXPECT(planish_fit_create(mesh, &options, &fit) == PLANISH_OK);
  EXPECT(steps > 0);
  planish_mesh_free(mesh); /* the fit needs it no more */
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK);
  EXPECT(info.converged && info.max_error <= 1e-10 && info.rms_error <= info.max_error);
  EXPECT(info.vertex_count == 8 && info.face_count == 6 && fabs(info.diagonal - sqrt(3.0)) < 1e-15);
  EXPECT(planish_fit_evaluate(fit, 2, &surface) == PLANISH_OK);
  EXPECT(planish_surface_view(surface, &arrays) == PLANISH_OK);
  EXPECT(arrays.face_count == 96 && arrays.face_offsets == NULL && arrays.base_count == 8);
  check_surface(&arrays, 1e-10 * sqrt(3.0));
  planish_surface_free(surface);
  options.progress = cancel;
  mesh = cube();
  surface = NULL;
  planish_fit_free(fit);
  fit = NULL;
  EXPECT_REFUSED(planish_fit_create(mesh, &options, &fit), PLANISH_CANCELLED, "cancelled");
  EXPECT(fit == NULL);
  options.progress = NULL;
  options.max_iterations = 1;
  options.method = PLANISH_METHOD_PROGRESSIVE;
  EXPECT_REFUSED(planish_fit_create(mesh, &options, &fit), PLANISH_NOT_CONVERGED,
                 " of the diagonal after iteration 1, and options.tolerance ");
  EXPECT(fit != NULL && planish_fit_get_info(fit, &info) == PLANISH_OK && !info.converged);
  EXPECT(info.iterations == 1 && info.method == PLANISH_METHOD_PROGRESSIVE);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
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
  planish_mesh* mesh = cube();
  planish_fit* fit = NULL;
  planish_queries* queries = NULL;
  planish_surface *coarse = NULL, *fine = NULL;
  planish_surface_arrays coarse_arrays, fine_arrays;
  planish_fit_options options;
  planish_place_answers on;
  planish_closest_answers near_to;
  planish_ray_answers hits;
  size_t i;
  planish_fit_options_init(&options, sizeof options);
  planish_place_answers_init(&on, sizeof on);
  planish_closest_answers_init(&near_to, sizeof near_to);
  planish_ray_answers_init(&hits, sizeof hits);
  planish_surface_arrays_init(&coarse_arrays, sizeof coarse_arrays);
  planish_surface_arrays_init(&fine_arrays, sizeof fine_arrays);
  options.tolerance = 1e-10;
  options.thread_count = 1;
  EXPECT(planish_fit_create(mesh, &options, &fit) == PLANISH_OK);
  EXPECT(planish_fit_tessellate(fit, 1e-2, 0, &coarse) == PLANISH_OK);
  EXPECT(planish_fit_tessellate(fit, 1e-3, 20, &fine) == PLANISH_OK);
  EXPECT(planish_surface_view(coarse, &coarse_arrays) == PLANISH_OK);
  EXPECT(planish_surface_view(fine, &fine_arrays) == PLANISH_OK);
  EXPECT(coarse_arrays.corner_count == 3 * coarse_arrays.face_count);
  EXPECT(coarse_arrays.face_count < fine_arrays.face_count && coarse_arrays.base_count == 8);
  check_surface(&coarse_arrays, 1e-10 * sqrt(3.0));
  EXPECT_REFUSED(planish_fit_tessellate(fit, 0, 0, &fine), PLANISH_INVALID_ARGUMENT, "chord error");
  planish_surface_free(coarse);
  planish_surface_free(fine);
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
  planish_fit_options options;
  planish_place_answers on;
  planish_closest_answers near_to;
  planish_ray_answers hits;
  double at[3] = {7, 7, 7}, no_number[3] = {0, 0, 0};
  planish_fit_options_init(&options, sizeof options);
  planish_place_answers_init(&on, sizeof on);
  planish_closest_answers_init(&near_to, sizeof near_to);
  planish_ray_answers_init(&hits, sizeof hits);
  on.positions = near_to.positions = hits.positions = at;
  no_number[1] = NAN;
  EXPECT(planish_fit_create(mesh, NULL, &fit) == PLANISH_OK);
  EXPECT(planish_queries_create(fit, &queries) == PLANISH_OK);
  EXPECT_REFUSED(planish_queries_create(fit, NULL), PLANISH_INVALID_ARGUMENT, "queries is NULL");
  EXPECT_REFUSED(planish_queries_create(NULL, &none), PLANISH_INVALID_ARGUMENT, "fit is NULL");
  EXPECT_REFUSED(planish_queries_evaluate(queries, &outside, 1, &on), PLANISH_INVALID_ARGUMENT,
                 "1.5");
  EXPECT_REFUSED(planish_queries_evaluate(queries, &nowhere, 1, &on), PLANISH_INVALID_ARGUMENT,
                 "6");
  EXPECT_REFUSED(planish_queries_evaluate(queries, NULL, 1, &on), PLANISH_INVALID_ARGUMENT,
                 "places is NULL");
  EXPECT_REFUSED(planish_queries_evaluate(queries, &outside, 1, NULL), PLANISH_INVALID_ARGUMENT,
                 "answers is NULL");
  EXPECT_REFUSED(planish_queries_closest(queries, no_number, 1, &near_to),
                 PLANISH_INVALID_ARGUMENT, "point");
  EXPECT_REFUSED(planish_queries_closest(queries, nothing, (size_t)-1, &near_to),
                 PLANISH_INVALID_ARGUMENT, "2^31");
  EXPECT_REFUSED(planish_queries_first_hit(queries, nothing, nothing, 1, 0, 1, &hits),
                 PLANISH_INVALID_ARGUMENT, "direction");
  near_to.struct_size = 1;
  EXPECT_REFUSED(planish_queries_closest(queries, nothing, 1, &near_to), PLANISH_INVALID_ARGUMENT,
                 "struct_size is 1");
  EXPECT(at[0] == 7 && at[1] == 7 && at[2] == 7);
  EXPECT(planish_queries_closest(queries, NULL, 0, NULL) == PLANISH_INVALID_ARGUMENT);
  planish_queries_free(queries);
  planish_queries_free(NULL);
  planish_fit_free(fit);
  fit = NULL;
  options.scheme = PLANISH_SCHEME_CATMULL_CLARK;
  options.max_iterations = 2;
  EXPECT(planish_fit_create(mesh, &options, &fit) != PLANISH_INVALID_ARGUMENT);
  EXPECT_REFUSED(planish_queries_create(fit, &none), PLANISH_INVALID_ARGUMENT, "DOO_SABIN");
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

static void test_verify(void) {
  planish_mesh* mesh = cube();
  planish_mesh* cage = NULL;
  planish_fit* fit = NULL;
  planish_mesh_arrays view;
  planish_verification found;
  planish_fit_options options;
  planish_fit_options_init(&options, sizeof options);
  options.method = PLANISH_METHOD_PROGRESSIVE;
  planish_mesh_arrays_init(&view, sizeof view);
  planish_verification_init(&found, sizeof found);
  EXPECT(planish_fit_create(mesh, &options, &fit) == PLANISH_OK);
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

/* Two triangles that almost share two vertices. */
static void test_weld(void) {
  static const double positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1e-7, 0, 1, 1, 0, 1e-7, 1, 0};
  static const int32_t corners[] = {0, 1, 2, 3, 4, 5}, sizes[] = {3, 3};
  planish_mesh* mesh = NULL;
  planish_fit* fit = NULL;
  planish_mesh_arrays arrays;
  planish_fit_options options;
  planish_fit_info info;
  planish_mesh_arrays_init(&arrays, sizeof arrays);
  planish_fit_options_init(&options, sizeof options);
  planish_fit_info_init(&info, sizeof info);
  arrays.positions = positions;
  arrays.vertex_count = 6;
  arrays.face_vertices = corners;
  arrays.corner_count = 6;
  arrays.face_sizes = sizes;
  arrays.face_count = 2;
  EXPECT(planish_mesh_create(&arrays, &mesh) == PLANISH_OK);
  EXPECT(planish_fit_create(mesh, &options, &fit) == PLANISH_OK);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK && info.vertex_count == 6);
  planish_fit_free(fit);
  options.weld = 1e-6;
  EXPECT(planish_fit_create(mesh, &options, &fit) == PLANISH_OK);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK && info.vertex_count == 4);
  planish_fit_free(fit);
  fit = NULL;
  options.weld = 0.5;
  EXPECT_REFUSED(planish_fit_create(mesh, &options, &fit), PLANISH_INVALID_ARGUMENT, "weld");
  planish_mesh_free(mesh);
}

static void test_files(const char* input) {
  planish_mesh* mesh = NULL;
  planish_fit* fit = NULL;
  planish_fit_info info;
  planish_fit_info_init(&info, sizeof info);
  EXPECT(planish_mesh_read(input, &mesh) == PLANISH_OK);
  EXPECT(planish_fit_create(mesh, NULL, &fit) == PLANISH_OK);
  EXPECT(planish_fit_write(fit, 1, "c_test.glb") == PLANISH_OK);
  EXPECT(planish_mesh_write(mesh, "c_test_mesh.ply") == PLANISH_OK);
  EXPECT(planish_fit_file(input, "c_test_file.glb", 1, NULL, &info) == PLANISH_OK);
  EXPECT(info.converged && info.vertex_count > 100);
  EXPECT_REFUSED(planish_mesh_read("none.obj", &mesh), PLANISH_UNREADABLE_INPUT, "none.obj");
  EXPECT_REFUSED(planish_fit_write(fit, 1, "none/a.glb"), PLANISH_UNWRITABLE_OUTPUT, "none");
  EXPECT_REFUSED(planish_fit_write(fit, 1, "a.step"), PLANISH_INVALID_ARGUMENT, ".glb");
  EXPECT_REFUSED(planish_fit_write(fit, 7, "a.glb"), PLANISH_INVALID_ARGUMENT, "7");
  EXPECT_REFUSED(planish_mesh_write(mesh, "a.glb"), PLANISH_INVALID_ARGUMENT, ".obj");
  EXPECT_REFUSED(planish_fit_file(input, input, 1, NULL, NULL), PLANISH_INVALID_ARGUMENT, "itself");
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

static void test_wrong_meshes(void) {
  planish_mesh_arrays arrays = cube_arrays();
  planish_mesh* mesh = NULL;
  static const int32_t bad_corners[] = {0, 2, 3, 8}, negative_size[] = {4, -4, 4, 4, 4, 4},
                       creases[] = {0, 8};
  EXPECT_REFUSED(planish_mesh_create(NULL, &mesh), PLANISH_INVALID_ARGUMENT, "arrays is NULL");
  EXPECT_REFUSED(planish_mesh_create(&arrays, NULL), PLANISH_INVALID_ARGUMENT, "mesh is NULL");
  arrays.struct_size = 0;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT, "struct_size is 0");
  arrays = cube_arrays();
  arrays.positions = NULL;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT,
                 "positions is NULL");
  arrays = cube_arrays();
  arrays.corner_count = 23;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT, "face 5 has 4");
  arrays.corner_count = 25;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT,
                 "corner_count is 25");
  arrays = cube_arrays();
  arrays.corners_per_face = 0;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT, "corners_per_face");
  arrays = cube_arrays();
  arrays.face_sizes = negative_size;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT, "face 1 has -4");
  arrays = cube_arrays();
  arrays.face_count = (size_t)-1;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT, "face_count");
  arrays = cube_arrays();
  arrays.vertex_count = (size_t)1 << 40;
  EXPECT_REFUSED(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT, "2^31");
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

static void test_wrong_options(void) {
  planish_mesh* mesh = cube();
  planish_mesh_arrays nothing;
  planish_mesh* empty = NULL;
  planish_fit* fit = NULL;
  planish_fit_options options;
  planish_fit_info info;
  planish_fit_options_init(&options, sizeof options);
  EXPECT_REFUSED(planish_fit_create(NULL, NULL, &fit), PLANISH_INVALID_ARGUMENT, "mesh is NULL");
  EXPECT_REFUSED(planish_fit_create(mesh, NULL, NULL), PLANISH_INVALID_ARGUMENT, "fit is NULL");
  EXPECT_REFUSED(planish_fit_get_info(NULL, &info), PLANISH_INVALID_ARGUMENT, "fit is NULL");
  EXPECT_REFUSED(planish_fit_file(NULL, "a.glb", 2, NULL, NULL), PLANISH_INVALID_ARGUMENT, "input");
  EXPECT_REFUSED(planish_verify(mesh, mesh, NULL, NULL), PLANISH_INVALID_ARGUMENT, "is NULL");
  options.tolerance = -1;
  EXPECT_REFUSED(planish_fit_create(mesh, &options, &fit), PLANISH_INVALID_ARGUMENT,
                 "options.tolerance is -1; ");
  planish_fit_options_init(&options, sizeof options);
  options.method = 77;
  EXPECT_REFUSED(planish_fit_create(mesh, &options, &fit), PLANISH_INVALID_ARGUMENT, "method");
  options.method = PLANISH_METHOD_FAIR;
  options.scheme = PLANISH_SCHEME_LOOP;
  EXPECT_REFUSED(planish_fit_create(mesh, &options, &fit), PLANISH_INVALID_ARGUMENT, "air");
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

/* A caller whose header ended behind `tolerance`, and one whose info ended behind `iterations`. */
static void test_older_structs(void) {
  planish_mesh* mesh = cube();
  planish_fit* fit = NULL;
  planish_fit_options options;
  planish_fit_info info;
  memset(&options, 0xff, sizeof options);
  planish_fit_options_init(&options, offsetof(planish_fit_options, max_iterations));
  EXPECT(options.struct_size == offsetof(planish_fit_options, max_iterations));
  EXPECT(options.tolerance == 1e-6 && options.max_iterations == -1 && options.weld != 0);
  EXPECT(planish_fit_create(mesh, &options, &fit) == PLANISH_OK);
  memset(&info, 0x5a, sizeof info);
  info.struct_size = offsetof(planish_fit_info, method);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK);
  EXPECT(info.converged == 1 && info.method == 0x5a5a5a5a);
  EXPECT(info.struct_size == offsetof(planish_fit_info, method));
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

// README begins
static planish_status print_surface(const char* path) {
  planish_mesh* mesh = NULL;
  planish_fit* fit = NULL;
  planish_surface* surface = NULL;
  planish_surface_arrays arrays;
  planish_status status = planish_mesh_read(path, &mesh);
  planish_surface_arrays_init(&arrays, sizeof arrays);
  if (status == PLANISH_OK) status = planish_fit_create(mesh, NULL, &fit);
  if (status == PLANISH_OK) status = planish_fit_evaluate(fit, 2, &surface);
  if (status == PLANISH_OK) status = planish_surface_view(surface, &arrays);
  if (status != PLANISH_OK) fprintf(stderr, "%s\n", planish_last_error());
  printf("%lu vertices\n", (unsigned long)arrays.vertex_count);
  planish_surface_free(surface);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
  return status;
}
// README ends

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  EXPECT(strcmp(planish_last_error(), "") == 0 && planish_last_error_element() == -1);
  EXPECT(strchr(planish_version(), '.') != NULL);
  EXPECT(print_surface(argv[1]) == PLANISH_OK);
  test_fit();
  test_verify();
  test_weld();
  test_files(argv[1]);
  test_wrong_meshes();
  test_wrong_options();
  test_older_structs();
  test_queries();
  test_wrong_queries();
  printf("planish %s: %d failures\n", planish_version(), failures);
  return failures == 0 ? 0 : 1;
}
