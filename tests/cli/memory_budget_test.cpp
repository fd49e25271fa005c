// What --memory and --temporary promise: the same bytes in less memory, and nothing that is left.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <vector>

#include "cli/needs.h"
#include "large_arrays.h"
#include "planish/surface/memory_need.h"

namespace planish::test {
namespace {

using command::give_back_array;
using command::hold_arrays_within;
using command::NoRoomForArray;
using command::take_large_array;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;

constexpr std::size_t kMiB = std::size_t{1} << 20;

class MemoryBudget : public Forecasts {
 protected:
  [[nodiscard]] double peak_of(const std::vector<std::string>& arguments) const {
    const ProcessResult run = fit(arguments, true);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.peak_bytes;
  }
};

std::size_t resident_bytes() {
  std::size_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST_F(MemoryBudget, BytesAreThoseOfAJobWithout) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers hold memory of their own";
#endif
  write("torus.obj", torus_obj(900));
  const double without = peak_of({"torus.obj", "-o", "a.ply", "--levels", "0"});
  const double within = peak_of({"torus.obj", "-o", "b.ply", "--levels", "0", "--memory", "256M"});
  EXPECT_GT(without, 300 * kMiB);
  EXPECT_LT(within, 256 * kMiB);
  EXPECT_EQ(read("a.ply"), read("b.ply"));
  EXPECT_EQ(names(), (std::vector<std::string>{"a.ply", "b.ply", "torus.obj"}));
}

#ifdef PLANISH_HAS_MESHER
TEST_F(MemoryBudget, PointsGiveTheSameMesh) {
  const ProcessResult made =
      fit({"--levels", "1", "-o", "points.ply", PLANISH_SCENES "/goblet.obj"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto reconstruct = [&](const std::string& output, std::vector<std::string> further) {
    further.insert(further.begin(), {"reconstruct", "points.ply", "-o", output});
    return run_planish(further, {.input = {}, .folder = path("")});
  };
  ASSERT_EQ(reconstruct("a.obj", {}).exit_code, 0);
  ASSERT_EQ(reconstruct("b.obj", {"--memory", "256M", "--temporary", "."}).exit_code, 0);
  EXPECT_EQ(read("a.obj"), read("b.obj"));
}
#endif

TEST_F(MemoryBudget, WhatIsKilledLeavesNothing) {
  const std::string input = write("torus.obj", torus_obj(450));
  std::filesystem::create_directory(path("temporary"));
  PlanishProcess process(
      {"fit", "--device", "cpu", input, "-o", path("a.ply"), "--levels", "4", "--memory", "256M",
       "--temporary", path("temporary"), "--progress", "json"},
      {});
  EXPECT_TRUE(process.wait_for_message("\"level\""));
  ::kill(process.id(), SIGKILL);
  EXPECT_EQ(process.finish().signal, SIGKILL);
  EXPECT_TRUE(std::filesystem::is_empty(path("temporary")));
}

TEST_F(MemoryBudget, WhatIsWrongIsSaid) {
  write("torus.obj", torus_obj(24));
  const auto said = [&](std::vector<std::string> arguments, int exit_code) {
    arguments.insert(arguments.begin(), {"torus.obj", "-o", "a.glb"});
    const ProcessResult result = fit(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    return result.err;
  };
  EXPECT_THAT(said({"--memory", "much"}, 2), HasSubstr("--memory: \"much\" is no size of up to"));
  EXPECT_THAT(said({"--memory", "6T"}, 2), HasSubstr("such as 6G or 800M"));
  EXPECT_THAT(said({"--memory", "100M"}, 2),
              HasSubstr("--memory: 100.0 MiB are too little; the least that works is 256M"));
  EXPECT_THAT(said({"--temporary", "."}, 2), HasSubstr("--temporary: is the folder of --memory"));
  EXPECT_THAT(said({"--memory", "1G", "--temporary", "no/where"}, 7),
              AllOf(HasSubstr("--temporary: no/where: cannot create a file"),
                    HasSubstr("No such file or directory")));
}

TEST_F(MemoryBudget, TheOutputsFolderNeedNotBeThere) {
  write("torus.obj", torus_obj(24));
  const ProcessResult result = fit({"torus.obj", "-o", "new/folder/", "--memory", "256M"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(exists("new/folder/torus.glb"));
}

TEST_F(MemoryBudget, ADryRunTellsTheDisk) {
  write("torus.obj", torus_obj(300));
  const std::vector<std::string> job{"torus.obj", "-o", "a.glb", "--levels", "5", "--dry-run"};
  std::vector<std::string> within = job;
  within.insert(within.end(), {"--memory", "256M"});
  const double all = forecast_memory(fit(job).out);
  ASSERT_GT(all, 300 * kMiB);
  EXPECT_THAT(fit(within).out,
              ContainsRegex("memory       256.0 MiB, and at most about .* in a temporary file in "
                            ".*, which has .* free"));
}

// Of this process, which no other test shares.
TEST_F(MemoryBudget, ArraysLeaveMemoryAndKeepTheirContent) {
  const auto work = [&] {
    EXPECT_EQ(take_large_array(64 * kMiB), nullptr);
    const std::uint64_t before = available_memory_bytes();
    hold_arrays_within(resident_bytes() + 96 * kMiB, path(""));
    EXPECT_GT(available_memory_bytes(), before);
    constexpr std::size_t kCount = 8, kWords = 32 * kMiB / sizeof(std::uint64_t);
    std::vector<std::uint64_t*> arrays;
    for (std::size_t a = 0; a < kCount; ++a) {
      arrays.push_back(static_cast<std::uint64_t*>(take_large_array(32 * kMiB)));
      std::iota(arrays.back(), arrays.back() + kWords, a << 32);
    }
    ::usleep(50'000);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    EXPECT_LT(resident_bytes(), 160 * kMiB);  // sanitizers hold a shadow of what was written, too
#endif
    for (std::size_t a = 0; a < kCount; ++a)
      for (std::size_t i = 0; i < kWords; ++i)
        if (arrays[a][i] != (a << 32) + i) return 1;
    for (std::uint64_t* const array : arrays)
      if (!give_back_array(array) || give_back_array(array)) return 2;
    // More than the disk has.
    const rlimit small{.rlim_cur = kMiB, .rlim_max = kMiB};
    ::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &small);
    try {
      (void)take_large_array(512 * kMiB);
      return 3;
    } catch (const std::bad_alloc&) {
      EXPECT_THAT(
          command::job_failure().message,
          AllOf(HasSubstr("--temporary: "), HasSubstr("cannot take room for 536870912 bytes"),
                HasSubstr("name a folder with more")));
    }
    return testing::Test::HasFailure() ? 4 : 0;
  };
  EXPECT_EXIT(std::_Exit(work()), testing::ExitedWithCode(0), "");
  EXPECT_TRUE(names().empty());
}

}  // namespace
}  // namespace planish::test
