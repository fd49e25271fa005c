#include "planish/job/job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "planish/core/json.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "planish/solve/backend.h"
#include "support/expect_error.h"
#include "support/files_below.h"
#include "support/meshes.h"
#include "support/temporary_folder.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Key;

class Run : public testing::Test {
 protected:
  Run() {
    write_mesh(folder_ / "cube.obj", FileFormat::Obj, cube());
    job_.name = job_.label = "cube";
    job_.input = folder_ / "cube.obj";
    job_.settings.set_levels({1});
  }
  void add(const char* name) {
    job_.outputs.push_back(surface_request(job_.settings, folder_ / name, "output"));
  }

  TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
  const std::unique_ptr<Backend> backend_ = make_cpu_backend({.thread_count = 1});
  Job job_;
};

TEST_F(Run, WritesAllOutputsWithReportAndPage) {
  add("a.glb");
  add("b.ply");
  add("c.step");
  job_.report = folder_ / "r.json";
  job_.page = folder_ / "p.html";
  const JobResult result = run(job_, *backend_);
  ASSERT_EQ(result.fitted.size(), 1u);
  EXPECT_EQ(result.fitted.front().mesh.face_count(), 6);
  ASSERT_EQ(result.report.outputs.size(), 3u);
  for (const WrittenOutput& output : result.report.outputs) {
    EXPECT_EQ(output.bytes, fs::file_size(output.path));
    EXPECT_EQ(output.sha256.size(), 64u);
  }
  EXPECT_THAT(files_below(folder_), ElementsAre(Key("a.glb"), Key("b.ply"), Key("c.step"),
                                                Key("cube.obj"), Key("p.html"), Key("r.json")));
  const auto report = nlohmann::json::parse(report_json(result.report));
  EXPECT_EQ(report["outputs"][2]["step"]["faces"], result.report.outputs[2].step->faces);
  EXPECT_EQ(report["solve"]["method"], "fair");
}

TEST_F(Run, TakesNoDigestWhereNoneIsWanted) {
  add("a.glb");
  job_.digests = false;
  const JobResult result = run(job_, *backend_);
  EXPECT_EQ(result.report.input.sha256, "");
  EXPECT_EQ(result.report.outputs.front().sha256, "");
}

TEST_F(Run, CallsTheSurfaceOfAFittedMeshAsItIsTold) {
  const FittedMesh fitted = fit_mesh(cube(), "cube", *backend_);
  (void)write_fitted_surface(folder_ / "a.gltf", fitted, *backend_, {.name = "part.v2"});
  std::ifstream file(folder_ / "a.gltf");
  EXPECT_EQ(nlohmann::json::parse(file)["meshes"][0]["name"], "part.v2");
}

TEST_F(Run, ClaimsEveryFileBeforeItWorks) {
  const auto refusal = [&](ErrorCode code) {
    return message_of(code, [&] { (void)run(job_, *backend_); });
  };
  add("cube.obj");
  EXPECT_THAT(refusal(ErrorCode::InvalidArgument), HasSubstr("is the input itself"));
  job_.outputs.clear();
  add("a.glb");
  job_.page = folder_ / "page.txt";
  EXPECT_THAT(refusal(ErrorCode::InvalidArgument), HasSubstr("a page is an .html file"));
  job_.page = folder_ / "p.html";
  job_.report = folder_ / "report.txt";
  EXPECT_THAT(refusal(ErrorCode::InvalidArgument), HasSubstr("a report is JSON"));
  job_.report = folder_ / "r.json";
  write_mesh(folder_ / "a.glb", FileFormat::Obj, cube());
  EXPECT_THAT(refusal(ErrorCode::UnwritableOutput), HasSubstr("exists"));
  EXPECT_THAT(files_below(folder_), ElementsAre(Key("a.glb"), Key("cube.obj")));
}

}  // namespace
}  // namespace planish::test
