#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "planish/job/job.h"
#include "planish/solve/backend.h"
#include "support/calls.h"
#include "support/files.h"
#include "support/meshes.h"

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
    job_.input = utf8(folder_ / "cube.obj");
    job_.settings.set_levels({1});
  }
  void add(const char* name) {
    job_.outputs.push_back(surface_request(job_.settings, utf8(folder_ / name), "output"));
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
  job_.report = utf8(folder_ / "r.json");
  job_.page = utf8(folder_ / "p.html");
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

// One that cannot be fitted does not stop the others.
TEST_F(Run, ManyFilesHavePagesAndAContactSheet) {
  std::ofstream(folder_ / "bad.obj") << "v 0 0 0\nf 1 2 3\n";
  write_mesh(folder_ / "ball.obj", FileFormat::Obj, icosphere(1));
  const std::vector<fs::path> inputs{folder_ / "cube.obj", folder_ / "bad.obj",
                                     folder_ / "ball.obj"};
  std::vector<double> shares;
  FitFilesOptions options{.extension = "ply", .pages = folder_ / "new/pages"};
  options.callbacks.progress = [&](std::string_view, double share) { shares.push_back(share); };
  const std::vector<std::string> failures = fit_files(inputs, folder_ / "new/out", options);
  EXPECT_THAT(failures, ElementsAre("", HasSubstr("bad.obj:2"), ""));
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_EQ(shares.back(), 1);
  EXPECT_THAT(files_below(folder_ / "new"),
              ElementsAre(Key("out/ball.ply"), Key("out/cube.ply"), Key("pages/ball.html"),
                          Key("pages/cube.html"), Key("pages/index.html")));
  std::ifstream sheet(folder_ / "new/pages/index.html");
  const std::string text(std::istreambuf_iterator<char>(sheet), {});
  EXPECT_THAT(text, HasSubstr("3 files"));
  EXPECT_THAT(text, HasSubstr("<a href=\"ball.html\">ball</a>"));
  EXPECT_THAT(text, HasSubstr("failed: "));
  const std::vector<fs::path> twice{inputs[0], inputs[0]};
  EXPECT_THROW((void)fit_files(twice, folder_ / "twice", options), Error);
  EXPECT_FALSE(fs::exists(folder_ / "twice"));
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
  job_.page = utf8(folder_ / "page.txt");
  EXPECT_THAT(refusal(ErrorCode::InvalidArgument), HasSubstr("a page is an .html file"));
  job_.page = utf8(folder_ / "p.html");
  job_.report = utf8(folder_ / "report.txt");
  EXPECT_THAT(refusal(ErrorCode::InvalidArgument), HasSubstr("a report is JSON"));
  job_.report = utf8(folder_ / "r.json");
  write_mesh(folder_ / "a.glb", FileFormat::Obj, cube());
  EXPECT_THAT(refusal(ErrorCode::UnwritableOutput), HasSubstr("exists"));
  EXPECT_THAT(files_below(folder_), ElementsAre(Key("a.glb"), Key("cube.obj")));
}

using testing::AllOf;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Limits : public testing::Test {
 protected:
  Limits() { write_mesh(input_, FileFormat::Obj, torus(200, 100, 2.0, 0.7)); }

  [[nodiscard]] std::string refusal(ErrorCode code, const WorkLimits& limits) const {
    return message_of(code, [&] {
      FitFileOptions options;
      options.settings.set_levels({3});
      options.limits = limits;
      options.report = folder_ / "r.json";
      (void)fit_file(input_, folder_ / "a.glb", options);
    });
  }

  TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
  const fs::path input_ = folder_ / "in.obj";
};

TEST_F(Limits, AreSaidWithWhatIsWanted) {
  EXPECT_THAT(refusal(ErrorCode::OutOfMemory, {.memory_bytes = 50'000'000}),
              AllOf(HasSubstr("level 3 needs about"), HasSubstr("where 47.7 MiB are free")));
  EXPECT_THAT(refusal(ErrorCode::OutOfMemory, {.points = 19'999}),
              HasSubstr("has 20,000 points, and 19,999 are allowed"));
  EXPECT_THAT(refusal(ErrorCode::UnwritableOutput, {.output_bytes = 1'000'000}),
              HasSubstr("more than the 976.6 KiB"));
  EXPECT_THAT(refusal(ErrorCode::Cancelled, {.cpu_seconds = 0.05}),
              HasSubstr("took the 0.05 s of processor time"));
  EXPECT_THAT(files_below(folder_), ElementsAre(Key("in.obj")));
}

TEST_F(Limits, DoNotChangeWhatKeepsThem) {
  FitFileOptions options;
  options.settings.set_levels({1});
  (void)fit_file(input_, folder_ / "a.glb", options);
  const std::string bytes = bytes_of(folder_ / "a.glb");
  options.limits = {.memory_bytes = std::uint64_t{1} << 30,
                    .cpu_seconds = 600,
                    .points = 20'000,
                    .output_bytes = bytes.size()};
  (void)fit_file(input_, folder_ / "a.glb", options);
  EXPECT_EQ(bytes_of(folder_ / "a.glb"), bytes);
}

// A service: many jobs at once, of which some break their limits. Each has its own files, warnings
// and errors, whatever the others do.
TEST(ManyJobs, AtOnceAreWhatTheyAreAlone) {
  constexpr int kJobs = 1000, kThreads = 50, kKinds = 5;
  const TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  const PolygonMesh meshes[kKinds] = {cube(), torus(12, 8, 2.0, 0.7), torus(16, 5, 2.0, 0.5),
                                      cube(), torus(9, 9, 1.0, 0.3)};
  std::map<int, std::string> alone;
  const auto input = [&](int kind) { return folder / ("in" + std::to_string(kind) + ".obj"); };
  const auto options_of = [](int kind) {
    FitFileOptions options;
    options.settings.set_levels({1 + kind % 2});
    options.limits = {.memory_bytes = std::uint64_t{1} << 30, .output_bytes = 1 << 20};
    if (kind == 3) options.limits.output_bytes = 1000;  // too few
    return options;
  };
  for (int kind = 0; kind < kKinds; ++kind) {
    write_mesh(input(kind), FileFormat::Obj, meshes[kind]);
    if (kind == 3) continue;
    const fs::path output = folder / ("alone" + std::to_string(kind) + ".glb");
    (void)fit_file(input(kind), output, options_of(kind));
    alone[kind] = bytes_of(output);
  }
  fs::create_directory(folder / "out");
  std::atomic<int> next = 0, failed = 0, wrong = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&] {
        for (int job = next++; job < kJobs; job = next++) {
          const int kind = job % kKinds;
          const fs::path output = folder / "out" / (std::to_string(job) + ".glb");
          FitFileOptions options = options_of(kind);
          const std::thread::id own = std::this_thread::get_id();
          options.callbacks.progress = [&](std::string_view, double) {
            if (std::this_thread::get_id() != own) ++wrong;
          };
          try {
            (void)fit_file(input(kind), output, options);
            if (bytes_of(output) != alone[kind]) ++wrong;
          } catch (const Error& error) {
            ++failed;
            if (kind != 3 || error.code() != ErrorCode::UnwritableOutput) ++wrong;
          }
        }
      });
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(failed, kJobs / kKinds);
  EXPECT_EQ(files_below(folder / "out").size(), std::size_t{kJobs - kJobs / kKinds});
}

}  // namespace
}  // namespace planish::test
