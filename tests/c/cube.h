/* What C programs of these tests share: counted failures, and a cube. */
#include <planish/c/planish.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int holds, const char* what, int line) {
  if (holds) return;
  ++failures;
  fprintf(stderr, "line %d: %s; last error: %s\n", line, what, planish_last_error());
}
#define EXPECT(condition) expect(condition, #condition, __LINE__)

static inline void expect_refused(planish_status given, planish_status wanted, const char* words,
                                  const char* what, int line) {
  expect(given == wanted, what, line);
  expect(strstr(planish_last_error(), words) != NULL, words, line);
}
#define EXPECT_REFUSED(call, status, words) expect_refused(call, status, words, #call, __LINE__)
#define EXPECT_INVALID(call, words) EXPECT_REFUSED(call, PLANISH_INVALID_ARGUMENT, words)

static const double kPositions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                    0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const int32_t kCorners[] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                                   2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};

static inline void set(planish_options* options, const char* name, const char* value) {
  EXPECT(planish_options_set(options, name, value) == PLANISH_OK);
}

/* The defaults, but for one. */
static inline planish_options* options_with(const char* name, const char* value) {
  planish_options* options = NULL;
  EXPECT(planish_options_create(&options) == PLANISH_OK);
  set(options, name, value);
  return options;
}

/* Faces of as many corners each. */
static inline planish_mesh_arrays arrays_of(const double* positions, size_t vertex_count,
                                            const int32_t* corners, size_t face_count,
                                            int corners_per_face) {
  planish_mesh_arrays arrays;
  planish_mesh_arrays_init(&arrays, sizeof arrays);
  arrays.positions = positions;
  arrays.vertex_count = vertex_count;
  arrays.face_count = face_count;
  arrays.corners_per_face = corners_per_face;
  arrays.face_vertices = corners;
  arrays.corner_count = face_count * (size_t)corners_per_face;
  return arrays;
}

static inline planish_mesh_arrays cube_arrays(void) {
  return arrays_of(kPositions, 8, kCorners, 6, 4);
}

static inline planish_mesh* made(planish_mesh_arrays arrays) {
  planish_mesh* mesh = NULL;
  EXPECT(planish_mesh_create(&arrays, &mesh) == PLANISH_OK);
  return mesh;
}

static inline planish_mesh* cube(void) { return made(cube_arrays()); }

static inline planish_fit* fitted(const planish_mesh* mesh, const planish_options* options) {
  planish_fit* fit = NULL;
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_OK);
  return fit;
}
