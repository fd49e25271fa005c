/* Numbers that C programs are given, each against what follows from others: errors from the
 * surface, derivatives from neighbouring places, curvatures from derivatives. */
#include <math.h>
#include <string.h>

#include "cube.h"

/* The errors of a fit that ended early are those of its surface: of a cube with a longer corner,
 * else all were alike. */
static void test_errors(void) {
  double positions[24], sum = 0, largest = 0;
  planish_mesh_arrays given = cube_arrays();
  planish_mesh *mesh = NULL, *cage = NULL;
  planish_fit* fit = NULL;
  planish_surface* surface = NULL;
  planish_options* options = options_with("interpolation", "progressive");
  planish_fit_info info;
  planish_surface_arrays arrays;
  planish_verification found;
  size_t i;
  memcpy(positions, kPositions, sizeof positions);
  positions[23] = 3;
  given.positions = positions;
  planish_fit_info_init(&info, sizeof info);
  planish_surface_arrays_init(&arrays, sizeof arrays);
  planish_verification_init(&found, sizeof found);
  set(options, "max_iterations", "1");
  mesh = made(given);
  EXPECT(planish_fit_create(mesh, options, &fit) == PLANISH_NOT_CONVERGED);
  EXPECT(planish_fit_get_info(fit, &info) == PLANISH_OK);
  EXPECT(planish_fit_evaluate(fit, 1, &surface) == PLANISH_OK);
  EXPECT(planish_surface_view(surface, &arrays) == PLANISH_OK && arrays.base_count == 8);
  for (i = 0; i < 8; ++i) {
    const double* p = arrays.positions + 3 * i;
    const double* q = positions + 3 * arrays.base_vertices[i];
    const double square = (p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) +
                          (p[2] - q[2]) * (p[2] - q[2]);
    sum += square;
    if (square > largest) largest = square;
  }
  EXPECT(largest > 1.5 * sum / 8);
  EXPECT(fabs(info.max_error - sqrt(largest) / info.diagonal) < 1e-12);
  EXPECT(fabs(info.rms_error - sqrt(sum / 8) / info.diagonal) < 1e-12);
  EXPECT(planish_fit_cage(fit, &cage) == PLANISH_OK);
  EXPECT(planish_verify(cage, mesh, options, &found) == PLANISH_OK && !found.confirmed);
  EXPECT(fabs(found.max_error - info.max_error) < 1e-12);
  EXPECT(fabs(found.rms_error - info.rms_error) < 1e-12);
  planish_surface_free(surface);
  planish_fit_free(fit);
  planish_options_free(options);
  planish_mesh_free(cage);
  planish_mesh_free(mesh);
}

static double dot(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Derivatives of a place by differences between its neighbours, curvatures by its derivatives. */
static void check_derivatives(const planish_queries* queries, const planish_place* at) {
  static const int kStep[9][2] = {{0, 0}, {1, 0},  {-1, 0}, {0, 1},  {0, -1},
                                  {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
  const double h = 1e-3;
  double p[27], normal[3], du[3], dv[3], duu[3], duv[3], dvv[3], along_largest[3],
      along_smallest[3];
  double mean, gaussian, largest, smallest, e, f, g, l, m, n, area;
  planish_place around[9];
  planish_place_answers on;
  int i, d;
  planish_place_answers_init(&on, sizeof on);
  for (i = 0; i < 9; ++i) {
    around[i] = *at;
    around[i].u += h * kStep[i][0];
    around[i].v += h * kStep[i][1];
  }
  on.positions = p;
  EXPECT(planish_queries_evaluate(queries, around, 9, &on) == PLANISH_OK);
  on.positions = NULL;
  on.normals = normal;
  on.du = du;
  on.dv = dv;
  on.duu = duu;
  on.duv = duv;
  on.dvv = dvv;
  on.mean = &mean;
  on.gaussian = &gaussian;
  on.largest = &largest;
  on.smallest = &smallest;
  on.largest_directions = along_largest;
  on.smallest_directions = along_smallest;
  EXPECT(planish_queries_evaluate(queries, at, 1, &on) == PLANISH_OK);
  for (d = 0; d < 3; ++d) {
    EXPECT(fabs(du[d] - (p[3 + d] - p[6 + d]) / (2 * h)) < 1e-4);
    EXPECT(fabs(dv[d] - (p[9 + d] - p[12 + d]) / (2 * h)) < 1e-4);
    EXPECT(fabs(duu[d] - (p[3 + d] - 2 * p[d] + p[6 + d]) / (h * h)) < 1e-4);
    EXPECT(fabs(dvv[d] - (p[9 + d] - 2 * p[d] + p[12 + d]) / (h * h)) < 1e-4);
    EXPECT(fabs(duv[d] - (p[15 + d] - p[18 + d] - p[21 + d] + p[24 + d]) / (4 * h * h)) < 1e-4);
  }
  /* The first and second forms; bending away from the normal counts as positive. */
  e = dot(du, du), f = dot(du, dv), g = dot(dv, dv), area = e * g - f * f;
  l = -dot(duu, normal), m = -dot(duv, normal), n = -dot(dvv, normal);
  EXPECT(fabs(mean - (e * n - 2 * f * m + g * l) / (2 * area)) < 1e-9);
  EXPECT(fabs(gaussian - (l * n - m * m) / area) < 1e-9);
  EXPECT(fabs(largest + smallest - 2 * mean) < 1e-9 && largest - smallest > 1e-3);
  EXPECT(fabs(largest * smallest - gaussian) < 1e-9);
  EXPECT(fabs(dot(along_largest, along_largest) - 1) < 1e-12);
  EXPECT(fabs(dot(along_smallest, along_smallest) - 1) < 1e-12);
  EXPECT(fabs(dot(along_largest, along_smallest)) < 1e-9);
  EXPECT(fabs(dot(along_largest, normal)) < 1e-9 && fabs(dot(along_smallest, normal)) < 1e-9);
  /* By a step a along u and b along v that is the direction: its normal curvature is the largest.
   */
  {
    const double x = dot(along_largest, du), y = dot(along_largest, dv);
    const double a = (g * x - f * y) / area, b = (e * y - f * x) / area;
    EXPECT(fabs(l * a * a + 2 * m * a * b + n * b * b - largest) < 1e-9);
  }
}

static void test_derivatives(void) {
  planish_options* rounded = options_with("creases", "use");
  static const planish_place places[] = {{2, 0.3, 0.4}, {5, 0.7, 0.1}, {0, 0.62, 0.81}};
  planish_mesh* mesh = cube();
  planish_fit* fit = fitted(mesh, rounded);
  planish_queries* queries = NULL;
  size_t i;
  EXPECT(planish_queries_create(fit, &queries) == PLANISH_OK);
  for (i = 0; i < 3; ++i) check_derivatives(queries, places + i);
  planish_queries_free(queries);
  planish_fit_free(fit);
  planish_options_free(rounded);
  planish_mesh_free(mesh);
}

int main(void) {
  test_errors();
  test_derivatives();
  return failures == 0 ? 0 : 1;
}
