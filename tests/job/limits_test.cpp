#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <vector>

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
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Key;

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
