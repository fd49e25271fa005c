// What planish-bench writes of kernels and frames on a device.
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include "cli/json_schema.h"
#include "planish/core/json.h"
#include "support/files.h"
#include "support/vulkan_device.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;

json read_json(const std::string& path) {
  std::ifstream file(path);
  return json::parse(file);
}

class BenchDevice : public testing::Test {
 protected:
  void SetUp() override { require_vulkan_device(); }

  // The valid JSON of a small run.
  json run(const std::string& arguments) {
    const std::string file = (folder_.path() / "bench.json").string();
    const std::string command = std::string(PLANISH_BENCH_EXECUTABLE) + " --smoke " + arguments +
                                " --json " + file + " > " + file + ".txt 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    json written = read_json(file);
    EXPECT_THAT(schema_problems(written, read_json(PLANISH_BENCH_SCHEMA)), IsEmpty());
    EXPECT_THAT(written["failed"], IsEmpty());
    return written;
  }
  // Of the first size that has it.
  static json row(const json& bench, const std::string& peer) {
    for (const json& row : bench["rows"])
      if (row["peer"] == peer) return row;
    ADD_FAILURE() << "no row " << peer;
    return {};
  }

  // Of a mesh that is no torus.
  static bool is_of_hubs(const json& row) {
    return row["size"].get<std::string>().starts_with("hubs of ");
  }

  TemporaryFolder folder_;
};

TEST_F(BenchDevice, KernelsBindTheBytesThatTheirLayoutsHold) {
  const json bench = run("--group kernels --hardware-kernels --repetitions 1");
  const auto per_element = [&](const char* peer) {
    return row(bench, peer)["figures"]["bytes_per_element"].get<double>();
  };
  // A vector is read and written.
  EXPECT_EQ(per_element("copy-kernel"), 32);
  EXPECT_EQ(per_element("vkCmdCopyBuffer"), 32);
  // An index, three floats, four floats.
  EXPECT_EQ(per_element("gather_points"), 4 + 12 + 16);
  // 2,500 rows of 9 entries of 8 bytes in 40 chunks of 64 rows and 66 words; the last, current,
  // first and next vectors; 65 records of a step, and the smallest buffer for squares, which nobody
  // sums.
  const double step = (40 * 64 * 9 * 8 + 40 * 66 * 4 + 2500 * 4 * 16 + 65 * 16 + 16) / 2500.0;
  EXPECT_NEAR(per_element("interpolation_step"), step, 1e-9);
  // Three displacements, of which the status names one, given points and displacement and control
  // points from them.
  EXPECT_NEAR(per_element("control_points"), 6 * 16 + 20 / 2500.0, 1e-9);
  EXPECT_EQ(row(bench, "interpolation_step")["figures"]["dispatches"], 5);
  EXPECT_EQ(row(bench, "corner_patches")["figures"]["dispatches"], 1);
}

TEST_F(BenchDevice, OneDispatchTakesAllStepsOfASmallMesh) {
  const json bench = run("--group kernels --hardware-kernels --repetitions 1 --points 256");
  EXPECT_EQ(row(bench, "all_steps")["figures"]["dispatches"], 1);
  EXPECT_EQ(row(bench, "frame")["figures"]["dispatches"], 7);
  EXPECT_EQ(row(bench, "frame")["figures"]["barriers"], 7);
}

// Those that walk around a vertex have a second dispatch where there are hubs, of a work group
// each.
TEST_F(BenchDevice, HubsHaveDispatchesOfTheirOwn) {
  const json bench = run("--group kernels --repetitions 1 --points 256");
  std::map<std::string, double> of_torus, of_hubs;
  for (const json& row : bench["rows"])
    (is_of_hubs(row) ? of_hubs : of_torus)[row["peer"].get<std::string>()] =
        row["figures"]["dispatches"].get<double>();
  for (const char* kernel : {"fair_polygons", "fair_descend", "fair_measure"}) {
    EXPECT_GT(of_torus[kernel], 0) << kernel;
    EXPECT_EQ(of_hubs[kernel], 2 * of_torus[kernel]) << kernel;
  }
  EXPECT_EQ(of_hubs["fair_lines"], of_torus["fair_lines"]);  // which goes by corners
}

// Bytes of an element, as tools/dev/bench/measurements.md says of 99,856 points. Here rows of
// chunks that are not full are up to a hundredth of all.
const std::map<std::string, double> kProgressiveBytes{
    {"gather_points", 32},       {"take_up", 48},        {"initial_residual", 108},
    {"interpolation_step", 140}, {"control_points", 96}, {"first_step", 36},
    {"corner_patches", 32},      {"frame", 1640}};
const std::map<std::string, double> kFairBytes{{"frame", 12239},        {"fair_lines", 2592},
                                               {"fair_descend", 2340},  {"fair_gradient", 2160},
                                               {"fair_mask_step", 668}, {"fair_offsets", 672}};

TEST_F(BenchDevice, KernelsBindAsManyBytesAsIsSaid) {
  const json bench = run("--group kernels --hardware-kernels --repetitions 1 --points 10000");
  json of_progressive = json::object(), of_fair = json::object();
  double net = 0;
  for (const json& row : bench["rows"]) {
    if (is_of_hubs(row)) continue;
    json& rows =
        row["size"].get<std::string>().find("fair") == std::string::npos ? of_progressive : of_fair;
    const std::string peer = row["peer"].get<std::string>();
    rows[peer] = row["figures"]["bytes_per_element"];
    if (peer.starts_with("fair_")) net += rows[peer].get<double>();
  }
  of_fair["frame"] = net;  // without its evaluation
  const auto compare = [](const json& counted, const std::map<std::string, double>& wanted) {
    for (const auto& [kernel, bytes] : wanted) {
      ASSERT_TRUE(counted.contains(kernel)) << kernel;
      EXPECT_NEAR(counted[kernel].get<double>(), bytes, 0.01 * bytes) << kernel;
    }
  };
  compare(of_progressive, kProgressiveBytes);
  compare(of_fair, kFairBytes);
}

TEST_F(BenchDevice, TheWholeFrameIsTheSumOfItsKernels) {
  const json bench = run("--group kernels --repetitions 1");
  double bytes = 0, dispatches = 0;
  for (const json& row : bench["rows"]) {
    if (row["peer"] == "copy-kernel" || row["peer"] == "vkCmdCopyBuffer") continue;
    const json& figures = row["figures"];
    if (row["peer"] == "frame") {
      EXPECT_EQ(figures["bytes"], bytes);
      EXPECT_EQ(figures["dispatches"], dispatches);
      break;
    }
    bytes += figures["bytes"].get<double>();
    dispatches += figures["dispatches"].get<double>();
  }
  EXPECT_GT(dispatches, 10);
}

TEST_F(BenchDevice, FramesConvergeWithinTheirTolerance) {
  const json bench = run("--group frame --points 900 --points 2500");
  int loops = 0;
  for (const json& row : bench["rows"]) {
    const json figures = row.value("figures", json::object());
    EXPECT_LE(figures.value("error", 0.0), 1.0001e-5);  // compared in float
    if (row["peer"] == "loop") ++loops;
  }
  EXPECT_EQ(loops, 2);
  const json frame = row(bench, "warm-frame")["figures"];
  EXPECT_NEAR(frame["predicted_ms_200"].get<double>(), 1e-6 * frame["bytes"].get<double>() / 200,
              1e-12);
  EXPECT_GT(frame["table_bytes"], 900 * 9 * 8);  // the limit masks' entries alone
  EXPECT_LE(row(bench, "warm-solve")["figures"]["iterations"],
            row(bench, "cold-solve")["figures"]["iterations"]);
}

TEST_F(BenchDevice, WhatADeviceRefusesIsNamedAndTheRestGoesOn) {
  const json bench =
      run("--group kernels --max-range 65536 --points 2500 --points 900 --repetitions 1");
  EXPECT_THAT(row(bench, "progressive")["refused"].get<std::string>(),
              HasSubstr("maxStorageBufferRange is 65536"));
  // 900 points go, in slices: their table does not fit one binding.
  EXPECT_EQ(row(bench, "interpolation_step")["figures"]["dispatches"], 2 * 5);
}

}  // namespace
}  // namespace planish::test
