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
#include <vector>

#include "planish/files/mesh_file.h"
#include "support/failing_memory.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Of a job's thousands of requests ever fewer, from both ends: what begins and what ends a job is
// in few. All of them takes minutes.
std::vector<std::int64_t> looked_at(std::int64_t count) {
  const bool all = std::getenv("PLANISH_EVERY_REQUEST") != nullptr;
  std::vector<std::int64_t> requests;
  for (std::int64_t n = 0; n < count; n += all ? 1 : 1 + n / 4) requests.push_back(n);
  for (std::int64_t n = 1; n < 100 && !all; n *= 2) requests.push_back(count - n);
  return requests;
}

class CJobsMemory : public testing::Test {
 protected:
  CJobsMemory() {
    EXPECT_EQ(planish_options_create(&options_), PLANISH_OK);
    set("threads", "1");
    set("creases", "use");
    set("levels", "1");
  }
  ~CJobsMemory() override { planish_options_free(options_); }

  void set(const char* name, const char* value) {
    EXPECT_EQ(planish_options_set(options_, name, value), PLANISH_OK) << planish_last_error();
  }

  [[nodiscard]] std::filesystem::path given(const char* name, const PolygonMesh& mesh) const {
    const std::filesystem::path path = folder_.path() / name;
    write_mesh(path, *format_of(path), mesh);
    return path;
  }

  // `end`: what the job ends with where it has memory.
  void expect_clean_ends(const std::filesystem::path& input, const char* output,
                         planish_status end = PLANISH_OK) {
    SCOPED_TRACE(input.filename().string() + " to " + output);
    const std::filesystem::path path = results_.path() / output;
    const auto job = [&] {
      return planish_fit_file(input.c_str(), path.c_str(), options_, nullptr);
    };
    ASSERT_EQ(job(), end) << planish_last_error();  // threads keep some of what they took
    planish_status status = PLANISH_INTERNAL_ERROR;
    const std::int64_t count = count_requests([&] { status = job(); });
    const std::string expected = bytes_of(path);
    int failures = 0;
    for (const std::int64_t n : looked_at(count)) {
      for (const auto& entry : std::filesystem::directory_iterator(results_.path()))
        std::filesystem::remove(entry.path());
      const bool has_failed = with_failing_request(n, [&] { status = job(); });
      if (!has_failed || status == end) {  // what can do without may come to its end
        ASSERT_EQ(status, end) << n << ": " << planish_last_error();
        ASSERT_EQ(bytes_of(path), expected) << n;
        continue;
      }
      ++failures;
      ASSERT_EQ(status, PLANISH_NO_MEMORY) << n << ": " << planish_last_error();
      for (const auto& entry : std::filesystem::directory_iterator(results_.path()))
        FAIL() << n << ": " << entry.path() << " is left";
    }
    EXPECT_GT(failures, 30);
  }

  // Whose requests all count.
  const oneapi::tbb::global_control one_thread_{
      oneapi::tbb::global_control::max_allowed_parallelism, 1};
  const TemporaryFolder folder_, results_;
  planish_options* options_ = nullptr;
};

TEST_F(CJobsMemory, MeshesToEveryFormat) {
  const auto mesh = given("laden.obj", laden_mesh(1));
  for (const char* name : {"a.obj", "a.ply", "a.off", "a.stl", "a.usda"})
    expect_clean_ends(mesh, name);
}

// A result that is not as it was asked for is there, and its words fail nothing.
TEST_F(CJobsMemory, WhatKeepsNoLimits) {
  set("step_tolerance", "1e-30");
  set("step_analytic", "off");
  expect_clean_ends(given("cube.off", cube()), "a.step", PLANISH_NOT_CONVERGED);
  set("interpolation", "progressive");
  set("max_iterations", "1");
  expect_clean_ends(given("open.ply", random_open_mesh(2)), "a.ply", PLANISH_NOT_CONVERGED);
}

// From OBJ a document is made, from glTF that of the file is changed in place.
TEST_F(CJobsMemory, GltfBothWays) {
  const auto mesh = given("laden.obj", laden_mesh(1)), asset = folder_.path() / "laden.glb";
  set("levels", "0");
  ASSERT_EQ(planish_fit_file(mesh.c_str(), asset.c_str(), options_, nullptr), PLANISH_OK);
  set("levels", "1");
  for (const char* name : {"a.gltf", "a.glb"}) {
    expect_clean_ends(mesh, name);
    expect_clean_ends(asset, name);
  }
  expect_clean_ends(asset, "a.ply");
}

TEST_F(CJobsMemory, OpenMeshesByBothMethods) {
  const auto mesh = given("open.ply", random_open_mesh(2));
  for (const char* method : {"progressive", "fair"}) {
    set("interpolation", method);
    expect_clean_ends(mesh, "a.ply");
    expect_clean_ends(mesh, "a.step");
  }
}

TEST_F(CJobsMemory, BothSchemes) {
  const auto mesh = given("prism.off", prism(5));
  for (const char* scheme : {"doo-sabin", "catmull-clark"}) {
    set("scheme", scheme);
    expect_clean_ends(mesh, "a.ply");
    expect_clean_ends(mesh, "a.step");
  }
}

}  // namespace
}  // namespace planish::test
