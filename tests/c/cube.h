/* What C programs of these tests share: counted failures, and a cube. */
#include <planish/c/planish.h>
#include <stdio.h>

static int failures = 0;

static void expect(int holds, const char* what, int line) {
  if (holds) return;
  ++failures;
  fprintf(stderr, "line %d: %s; last error: %s\n", line, what, planish_last_error());
}
#define EXPECT(condition) expect(condition, #condition, __LINE__)

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

static inline planish_mesh* cube(void) {
  const planish_mesh_arrays arrays = cube_arrays();
  planish_mesh* mesh = NULL;
  EXPECT(planish_mesh_create(&arrays, &mesh) == PLANISH_OK);
  return mesh;
}
