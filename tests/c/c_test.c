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
  EXPECT(planish_fit_create(mesh, &options, &fit) == PLANISH_NOT_CONVERGED);
  EXPECT(fit != NULL && planish_fit_get_info(fit, &info) == PLANISH_OK && !info.converged);
  EXPECT(info.iterations == 1 && info.method == PLANISH_METHOD_PROGRESSIVE);
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
  EXPECT_REFUSED(planish_fit_create(mesh, &options, &fit), PLANISH_INVALID_ARGUMENT, "tolerance");
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
  printf("planish %s: %d failures\n", planish_version(), failures);
  return failures == 0 ? 0 : 1;
}
