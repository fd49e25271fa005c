// Memory runs out at every place where a function of planish.h takes some, one after another: it
// says so by its status, gives no handle, and its next call succeeds.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <planish/c/editor.h>
#include <planish/c/planish.h>

#include <cstdint>
#include <functional>
#include <string>

#include "planish/mesh/polygon_mesh.h"
#include "support/failing_memory.h"
#include "support/files.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

// The defaults on one thread, by a method; NULL: the default one.
planish_options* one_thread_options(const char* method = nullptr) {
  planish_options* options = nullptr;
  EXPECT_EQ(planish_options_create(&options), PLANISH_OK);
  EXPECT_EQ(planish_options_set(options, "threads", "1"), PLANISH_OK);
  EXPECT_EQ(planish_options_set(options, "levels", "1"), PLANISH_OK);
  if (method != nullptr) {
    EXPECT_EQ(planish_options_set(options, "interpolation", method), PLANISH_OK);
  }
  return options;
}

planish_mesh_arrays arrays_of(const PolygonMesh& mesh) {
  planish_mesh_arrays arrays;
  planish_mesh_arrays_init(&arrays, sizeof arrays);
  arrays.positions = &mesh.positions[0].x;
  arrays.vertex_count = mesh.positions.size();
  arrays.face_vertices = mesh.face_vertices.data();
  arrays.corner_count = mesh.face_vertices.size();
  arrays.corners_per_face = 4;
  arrays.face_count = arrays.corner_count / 4;
  return arrays;
}

// On one thread, whose requests all count.
struct OneThread {
  oneapi::tbb::global_control control{oneapi::tbb::global_control::max_allowed_parallelism, 1};
};

// Calls `function` until no request of it fails. Returns how many it makes.
std::int64_t expect_no_memory(const char* name, const std::function<planish_status()>& function) {
  SCOPED_TRACE(name);
  // Once with memory: TBB waits for ever where there is none for the start of its threads.
  EXPECT_EQ(function(), PLANISH_OK) << planish_last_error();
  for (std::int64_t n = 0;; ++n) {
    planish_status status = PLANISH_INTERNAL_ERROR;
    const bool has_failed = with_failing_request(n, [&] { status = function(); });
    if (!has_failed || status == PLANISH_OK) {  // what can do without may come to its end
      EXPECT_EQ(status, PLANISH_OK) << planish_last_error();
      if (!has_failed || testing::Test::HasFailure()) return n;
      continue;
    }
    EXPECT_EQ(status, PLANISH_NO_MEMORY) << n << ": " << planish_last_error();
    EXPECT_NE(std::string(planish_last_error()).find("memory"), std::string::npos)
        << n << ": " << planish_last_error();
    if (testing::Test::HasFailure()) return n;
  }
}

// The same of a function that makes a handle. Returns the last one.
template <class Handle>
Handle* made(const char* name, void (*free_handle)(Handle*),
             const std::function<planish_status(Handle**)>& make) {
  Handle* handle = nullptr;
  const std::int64_t requests = expect_no_memory(name, [&] {
    free_handle(handle);
    handle = nullptr;
    const planish_status status = make(&handle);
    EXPECT_EQ(handle != nullptr, status == PLANISH_OK);
    return status;
  });
  EXPECT_GT(requests, 0) << name;
  return handle;
}

TEST(CMemory, EveryFunctionSaysThatThereIsNone) {
  const OneThread one_thread;
  const TemporaryFolder folder;
  const std::string mesh_path = (folder.path() / "mesh.ply").string();
  const std::string surface_path = (folder.path() / "surface.ply").string();
  const PolygonMesh torus = test::torus(4, 3, 3, 1);
  const planish_mesh_arrays arrays = arrays_of(torus);
  planish_options* made_here =
      made<planish_options>("planish_options_create", planish_options_free, planish_options_create);
  expect_no_memory("planish_options_set", [&] {
    // Longer than what stands in a string itself.
    return planish_options_set(made_here, "step_tolerance", "0.0000000000000000000000000000000001");
  });
  const char* text = nullptr;
  ASSERT_EQ(planish_options_get(made_here, "step_tolerance", &text), PLANISH_OK);
  EXPECT_STREQ(text, "1e-34");
  const std::int32_t sharp[] = {0, 1};
  expect_no_memory("planish_options_set_sharp",
                   [&] { return planish_options_set_sharp(made_here, sharp, 1, sharp, 2); });
  planish_options_free(made_here);
  planish_options* options = one_thread_options();
  planish_options* progressive = one_thread_options("progressive");
  planish_mesh* mesh = made<planish_mesh>(
      "planish_mesh_create", planish_mesh_free,
      [&](planish_mesh** handle) { return planish_mesh_create(&arrays, handle); });
  expect_no_memory("planish_mesh_write",
                   [&] { return planish_mesh_write(mesh, mesh_path.c_str()); });
  planish_mesh* read = made<planish_mesh>(
      "planish_mesh_read", planish_mesh_free,
      [&](planish_mesh** handle) { return planish_mesh_read(mesh_path.c_str(), handle); });
  planish_fit* fit = made<planish_fit>(
      "planish_fit_create", planish_fit_free,
      [&](planish_fit** handle) { return planish_fit_create(mesh, options, handle); });
  planish_fit* of_cage = nullptr;
  ASSERT_EQ(planish_fit_create(mesh, progressive, &of_cage), PLANISH_OK);
  planish_mesh* cage =
      made<planish_mesh>("planish_fit_cage", planish_mesh_free,
                         [&](planish_mesh** handle) { return planish_fit_cage(of_cage, handle); });
  planish_surface* surface = made<planish_surface>(
      "planish_fit_evaluate", planish_surface_free,
      [&](planish_surface** handle) { return planish_fit_evaluate(fit, 1, handle); });
  planish_surface_free(surface);
  surface = made<planish_surface>(
      "planish_fit_tessellate", planish_surface_free,
      [&](planish_surface** handle) { return planish_fit_tessellate(fit, 0.05, 0, handle); });
  planish_queries* queries = made<planish_queries>(
      "planish_queries_create", planish_queries_free,
      [&](planish_queries** handle) { return planish_queries_create(fit, handle); });
  expect_no_memory("planish_fit_write",
                   [&] { return planish_fit_write(fit, 1, surface_path.c_str()); });
  expect_no_memory("planish_fit_file", [&] {
    return planish_fit_file(mesh_path.c_str(), surface_path.c_str(), options, nullptr);
  });
  planish_verification found;
  planish_verification_init(&found, sizeof found);
  expect_no_memory("planish_verify",
                   [&] { return planish_verify(cage, mesh, progressive, &found); });

  const planish_place place{0, 0.5, 0.5};
  const double point[] = {9, 1, 2}, direction[] = {-1, 0, 0};
  double at[3];
  planish_place_answers places;
  planish_closest_answers closest;
  planish_ray_answers hits;
  planish_place_answers_init(&places, sizeof places);
  planish_closest_answers_init(&closest, sizeof closest);
  planish_ray_answers_init(&hits, sizeof hits);
  places.positions = closest.positions = hits.positions = at;
  expect_no_memory("planish_queries_evaluate",
                   [&] { return planish_queries_evaluate(queries, &place, 1, &places); });
  expect_no_memory("planish_queries_closest",
                   [&] { return planish_queries_closest(queries, point, 1, &closest); });
  expect_no_memory("planish_queries_first_hit", [&] {
    return planish_queries_first_hit(queries, point, direction, 1, 0, 100, &hits);
  });
  planish_queries_free(queries);
  planish_surface_free(surface);
  planish_fit_free(fit);
  planish_fit_free(of_cage);
  planish_options_free(options);
  planish_options_free(progressive);
  for (planish_mesh* handle : {cage, read, mesh}) planish_mesh_free(handle);
}

// Whatever was missing, an editor whose call has succeeded has the rows of its own control points.
void check_rows(const planish_editor* editor) {
  planish_editor_arrays arrays;
  planish_editor_arrays_init(&arrays, sizeof arrays);
  ASSERT_EQ(planish_editor_view(editor, &arrays), PLANISH_OK);
  planish_fit* fit = nullptr;
  planish_surface* surface = nullptr;
  ASSERT_EQ(planish_editor_fit(editor, &fit), PLANISH_OK);
  ASSERT_EQ(planish_fit_evaluate(fit, 1, &surface), PLANISH_OK);
  planish_surface_arrays rows;
  planish_surface_arrays_init(&rows, sizeof rows);
  ASSERT_EQ(planish_surface_view(surface, &rows), PLANISH_OK);
  ASSERT_EQ(rows.vertex_count, arrays.row_count);
  for (std::size_t i = 0; i < 3 * rows.vertex_count; ++i)
    ASSERT_NEAR(rows.positions[i], arrays.positions[i], 1e-12) << i;
  planish_surface_free(surface);
  planish_fit_free(fit);
}

TEST(CMemory, EditorsGoOnWhereThereWasNone) {
  const OneThread one_thread;
  const PolygonMesh torus = test::torus(40, 30, 3, 1);
  const planish_mesh_arrays arrays = arrays_of(torus);
  planish_mesh* mesh = nullptr;
  ASSERT_EQ(planish_mesh_create(&arrays, &mesh), PLANISH_OK);
  for (const char* method : {"progressive", "fair"}) {
    planish_options* options = one_thread_options(method);
    planish_fit* fit = nullptr;
    ASSERT_EQ(planish_fit_create(mesh, options, &fit), PLANISH_OK);
    planish_options_free(options);
    planish_editor* editor = made<planish_editor>(
        "planish_editor_create", planish_editor_free,
        [&](planish_editor** handle) { return planish_editor_create(fit, 1, handle); });
    double place = 0;
    const auto move = [&] {
      place += 0.001;
      const std::int32_t vertices[] = {600, 31, 777};
      double to[9];
      for (int i = 0; i < 9; ++i) to[i] = torus.positions[vertices[i / 3]][i % 3] + place;
      planish_edit_change change;
      planish_edit_change_init(&change, sizeof change);
      return planish_editor_move(editor, vertices, to, 3, &change);
    };
    expect_no_memory("planish_editor_move", move);
    check_rows(editor);
    expect_no_memory("planish_editor_undo", [&] { return planish_editor_undo(editor, nullptr); });
    check_rows(editor);
    expect_no_memory("planish_editor_settle",
                     [&] { return planish_editor_settle(editor, nullptr); });
    expect_no_memory("planish_editor_refit", [&] { return planish_editor_refit(editor, nullptr); });
    check_rows(editor);
    bool is_sharp = false;
    expect_no_memory("planish_editor_set_sharp", [&] {
      const std::int32_t edge[] = {31, 32}, corner = 600;
      is_sharp = !is_sharp;
      return planish_editor_set_sharp(editor, edge, 1, &corner, 1, is_sharp ? 1 : 0, nullptr);
    });
    check_rows(editor);
    const std::int32_t *found = nullptr, vertex = 3;
    const double* weights = nullptr;
    std::size_t count = 0;
    expect_no_memory("planish_editor_select", [&] {
      return planish_editor_select(editor, &vertex, 1, 0.5, &found, &weights, &count);
    });
    planish_fit* now =
        made<planish_fit>("planish_editor_fit", planish_fit_free,
                          [&](planish_fit** handle) { return planish_editor_fit(editor, handle); });
    planish_fit_free(now);
    planish_editor_free(editor);
    planish_fit_free(fit);
  }
  planish_mesh_free(mesh);
}

// What a caller counts wrongly is refused by its counts, before memory is taken for so many.
TEST(CMemory, WrongCountsTakeNone) {
  const PolygonMesh torus = test::torus(4, 3, 3, 1);
  planish_mesh_arrays arrays = arrays_of(torus);
  arrays.face_count = 1'000'000'000;
  planish_mesh* mesh = nullptr;
  largest_request = 0;
  EXPECT_EQ(planish_mesh_create(&arrays, &mesh), PLANISH_INVALID_ARGUMENT);
  EXPECT_EQ(mesh, nullptr);
  EXPECT_EQ(std::string(planish_last_error()),
            "face 12 has 4 corners, and 0 of corner_count are left");
  EXPECT_LT(largest_request, 10'000u);
}

}  // namespace
}  // namespace planish::test
