/* What rides on a mesh goes in as arrays and comes back on its surface. */
#include <math.h>
#include <string.h>

#include "cube.h"

static const double kUvs[] = {0, 0, 1, 0, 1, 1, 0, 1};
static const char* const kNames[] = {"top", "rest"};
static const char* const kMaterials[] = {NULL, "stone"};
static const int32_t kGroups[] = {0, 1, 1, 1, 1, 1};
static int32_t face_uvs[24];
static float colors[32], heat[8], flow[24];
static planish_attribute attributes[2];

/* Numbers that are linear in the position, so that each follows from the others. */
static planish_mesh_arrays riding_cube(void) {
  planish_mesh_arrays arrays = cube_arrays();
  int i, k;
  for (i = 0; i < 24; ++i) face_uvs[i] = i % 4;
  for (i = 0; i < 8; ++i) {
    heat[i] = 0;
    colors[4 * i + 3] = 1;
    for (k = 0; k < 3; ++k) {
      const float x = (float)kPositions[3 * i + k];
      colors[4 * i + k] = x;
      flow[3 * i + k] = 7 * x;
      heat[i] += (float)(k + 1) * x;
    }
  }
  attributes[0].name = "heat", attributes[0].width = 1, attributes[0].values = heat;
  attributes[1].name = "flow", attributes[1].width = 3, attributes[1].values = flow;
  arrays.uvs = kUvs, arrays.uv_count = 4, arrays.face_uvs = face_uvs;
  arrays.colors = colors;
  arrays.group_names = kNames, arrays.group_materials = kMaterials, arrays.group_count = 2;
  arrays.face_groups = kGroups;
  arrays.attributes = attributes, arrays.attribute_count = 2;
  return arrays;
}

static void test_mesh(void) {
  planish_mesh_arrays found;
  planish_mesh* mesh = made(riding_cube());
  planish_mesh_arrays_init(&found, sizeof found);
  EXPECT(planish_mesh_view(mesh, &found) == PLANISH_OK);
  EXPECT(found.uv_count == 4 && memcmp(found.uvs, kUvs, sizeof kUvs) == 0);
  EXPECT(memcmp(found.face_uvs, face_uvs, sizeof face_uvs) == 0);
  EXPECT(memcmp(found.colors, colors, sizeof colors) == 0);
  EXPECT(found.group_count == 2 && strcmp(found.group_names[1], "rest") == 0);
  EXPECT(strcmp(found.group_materials[0], "") == 0);
  EXPECT(strcmp(found.group_materials[1], "stone") == 0);
  EXPECT(memcmp(found.face_groups, kGroups, sizeof kGroups) == 0);
  EXPECT(found.attribute_count == 2 && strcmp(found.attributes[1].name, "flow") == 0);
  EXPECT(found.attributes[1].width == 3);
  EXPECT(memcmp(found.attributes[1].values, flow, sizeof flow) == 0);
  planish_mesh_free(mesh);
  mesh = cube(); /* that has nothing of it */
  EXPECT(planish_mesh_view(mesh, &found) == PLANISH_OK);
  EXPECT(found.uvs == NULL && found.face_uvs == NULL && found.colors == NULL);
  EXPECT(found.face_groups == NULL && found.group_count == 0 && found.attribute_count == 0);
  planish_mesh_free(mesh);
}

static void check_surface(const planish_surface* surface) {
  planish_surface_arrays found;
  size_t i, k, named[2] = {0, 0};
  planish_surface_arrays_init(&found, sizeof found);
  EXPECT(planish_surface_view(surface, &found) == PLANISH_OK);
  EXPECT(found.attribute_count == 2 && found.group_count == 2);
  for (i = 0; i < found.vertex_count; ++i) {
    const float* rgba = found.colors + 4 * i;
    const float* of_flow = found.attributes[1].values + 3 * i;
    float of_heat = 0;
    for (k = 0; k < 3; ++k) {
      EXPECT(fabsf(of_flow[k] - 7 * rgba[k]) < 1e-5f);
      of_heat += (float)(k + 1) * rgba[k];
    }
    EXPECT(fabsf(of_heat - found.attributes[0].values[i]) < 1e-5f);
  }
  for (i = 0; i < found.base_count; ++i)
    EXPECT(found.attributes[0].values[i] == heat[found.base_vertices[i]]);
  for (i = 0; i < found.corner_count; ++i)
    EXPECT(found.face_uvs[i] >= 0 && (size_t)found.face_uvs[i] < found.uv_count);
  for (i = 0; i < found.face_count; ++i) ++named[found.face_groups[i] != 0];
  EXPECT(named[0] > 0 && named[0] + named[1] == found.face_count);
}

static void test_surfaces(void) {
  planish_mesh* mesh = made(riding_cube());
  planish_fit* fit = fitted(mesh, NULL);
  planish_surface *level = NULL, *triangles = NULL;
  EXPECT(planish_fit_evaluate(fit, 2, &level) == PLANISH_OK);
  EXPECT(planish_fit_tessellate(fit, 1e-2, 0, &triangles) == PLANISH_OK);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
  check_surface(level);
  check_surface(triangles);
  planish_surface_free(level);
  planish_surface_free(triangles);
}

static void test_faults(void) {
  planish_mesh_arrays arrays = riding_cube();
  planish_mesh* mesh = NULL;
  arrays.uvs = NULL;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "uvs is NULL, with 4 elements");
  arrays = riding_cube(), arrays.face_uvs = NULL;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh),
                 "face_uvs is NULL, with 4 texture coordinates");
  arrays = riding_cube(), face_uvs[3] = 4;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "face_uvs[3] is 4 of 4");
  arrays = riding_cube(), arrays.face_groups = NULL;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "face_groups is NULL");
  arrays = riding_cube(), arrays.group_count = 1;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "face_groups[1] is 1 of 1");
  arrays = riding_cube(), arrays.attributes = NULL;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "attributes is NULL, with 2 elements");
  arrays = riding_cube(), attributes[1].name = NULL;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "the name of an attribute is NULL");
  arrays = riding_cube(), attributes[1].name = "HEAT";
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "attribute \"HEAT\": is there twice");
  arrays = riding_cube(), attributes[1].name = "2d";
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "attribute \"2d\": is no name");
  arrays = riding_cube(), attributes[1].width = 0;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "attribute \"flow\" has a width of 0");
  arrays = riding_cube(), attributes[1].values = NULL;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "the values of an attribute is NULL");
  arrays = riding_cube(), flow[10] = (float)NAN;
  EXPECT_INVALID(planish_mesh_create(&arrays, &mesh), "attribute \"flow\": of vertex 3 is nan");
  EXPECT(mesh == NULL);
  planish_mesh_free(made(riding_cube())); /* as it is: nothing is wrong */
}

/* A caller that was compiled before there was anything of this. */
static void test_older_header(void) {
  planish_mesh_arrays older = riding_cube();
  planish_mesh* mesh = NULL;
  older.struct_size = offsetof(planish_mesh_arrays, uvs);
  EXPECT(planish_mesh_create(&older, &mesh) == PLANISH_OK);
  {
    planish_mesh_arrays found;
    planish_mesh_arrays_init(&found, sizeof found);
    EXPECT(planish_mesh_view(mesh, &found) == PLANISH_OK);
    EXPECT(found.uv_count == 0 && found.colors == NULL && found.attribute_count == 0);
  }
  planish_mesh_free(mesh);
}

int main(void) {
  test_mesh();
  test_surfaces();
  test_faults();
  test_older_header();
  return failures == 0 ? 0 : 1;
}
