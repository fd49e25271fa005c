// Memory runs out at one place after another where a whole job takes some, from file to file: it
// says so, leaves no file, and the next job writes the bytes that it should.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <planish/c/planish.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "planish/files/mesh_file.h"
#include "support/failing_memory.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "support/temporary_folder.h"

namespace planish::test {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class CJobsMemory : public testing::Test {
 protected:
  CJobsMemory() {
    planish_fit_options_init(&options_, sizeof options_);
    options_.thread_count = 1;
  }

  [[nodiscard]] std::filesystem::path given(const char* name, const PolygonMesh& mesh) const {
    const std::filesystem::path path = folder_.path() / name;
    write_mesh(path, *format_of(path), mesh);
    return path;
  }

  void expect_clean_ends(const std::filesystem::path& input, const char* output) {
    SCOPED_TRACE(input.filename().string() + " to " + output);
    const std::filesystem::path path = results_.path() / output;
    const auto job = [&] {
      return planish_fit_file(input.c_str(), path.c_str(), 1, &options_, nullptr);
    };
    ASSERT_EQ(job(), PLANISH_OK) << planish_last_error();
    const std::string expected = bytes_of(path);
    // Ever wider steps: a job makes thousands of requests. All of them takes minutes.
    const std::int64_t steps = std::getenv("PLANISH_EVERY_REQUEST") != nullptr ? 1 << 20 : 8;
    int failures = 0;
    for (std::int64_t n = 0;; n += 1 + n / steps) {
      for (const auto& entry : std::filesystem::directory_iterator(results_.path()))
        std::filesystem::remove(entry.path());
      planish_status status = PLANISH_INTERNAL_ERROR;
      const bool has_failed = with_failing_request(n, [&] { status = job(); });
      if (!has_failed || status == PLANISH_OK) {  // what can do without may come to its end
        ASSERT_EQ(status, PLANISH_OK) << n << ": " << planish_last_error();
        ASSERT_EQ(bytes_of(path), expected) << n;
        if (!has_failed) break;
        continue;
      }
      ++failures;
      ASSERT_EQ(status, PLANISH_NO_MEMORY) << n << ": " << planish_last_error();
      ASSERT_TRUE(std::filesystem::is_empty(results_.path())) << n;
    }
    EXPECT_GT(failures, 30);
  }

  // Whose requests all count.
  const oneapi::tbb::global_control one_thread_{
      oneapi::tbb::global_control::max_allowed_parallelism, 1};
  const TemporaryFolder folder_, results_;
  planish_fit_options options_;
};

TEST_F(CJobsMemory, MeshesToEveryFormat) {
  const auto mesh = given("laden.obj", laden_mesh(1));
  for (const char* name : {"a.obj", "a.ply", "a.off", "a.stl", "a.usda"})
    expect_clean_ends(mesh, name);
}

// From OBJ a document is made, from glTF that of the file is changed in place.
TEST_F(CJobsMemory, GltfBothWays) {
  const auto mesh = given("laden.obj", laden_mesh(1)), asset = folder_.path() / "laden.glb";
  ASSERT_EQ(planish_fit_file(mesh.c_str(), asset.c_str(), 0, &options_, nullptr), PLANISH_OK);
  for (const char* name : {"a.gltf", "a.glb"}) {
    expect_clean_ends(mesh, name);
    expect_clean_ends(asset, name);
  }
  expect_clean_ends(asset, "a.ply");
}

TEST_F(CJobsMemory, OpenMeshesByBothMethods) {
  const auto mesh = given("open.ply", random_open_mesh(2));
  for (const int method : {PLANISH_METHOD_PROGRESSIVE, PLANISH_METHOD_FAIR}) {
    options_.method = method;
    expect_clean_ends(mesh, "a.ply");
    expect_clean_ends(mesh, "a.step");
  }
}

TEST_F(CJobsMemory, BothSchemes) {
  const auto mesh = given("prism.off", prism(5));
  for (const int scheme : {PLANISH_SCHEME_DOO_SABIN, PLANISH_SCHEME_CATMULL_CLARK}) {
    options_.scheme = scheme;
    expect_clean_ends(mesh, "a.ply");
    expect_clean_ends(mesh, "a.step");
  }
}

}  // namespace
}  // namespace planish::test
