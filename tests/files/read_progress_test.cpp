// Readers tell how far they are: on the calling thread, rising to 1, whatever the format.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "files/read_bytes.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/read_obj.h"
#include "planish/files/read_file.h"
#include "planish/files/readers.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

constexpr int kCount = 10'000;  // vertices, and as many faces where there are some

struct ProgressFile {
  std::string name;
  std::string bytes;
};

std::string lines(int count, const std::function<std::string(int)>& line) {
  std::string text;
  for (int i = 0; i < count; ++i) text += line(i) + "\n";
  return text;
}

std::string point(int i) { return std::to_string(i) + " " + std::to_string(i * i % 97) + " 1"; }

std::string triangle(int i, int first) {
  const auto corner = [&](int k) { return std::to_string(first + (i + k) % kCount); };
  return corner(0) + " " + corner(1) + " " + corner(2);
}

std::vector<ProgressFile> progress_files() {
  const std::string count = std::to_string(kCount);
  const std::string xyz = lines(kCount, point);
  const std::string threes = lines(kCount, [](int i) { return "3 " + triangle(i, 0); });
  const std::string facets = lines(kCount, [](int i) {
    return "facet normal 0 0 1\nouter loop\nvertex " + point(i) + "\nvertex " + point(i + 1) +
           "\nvertex " + point(i + 3) + "\nendloop\nendfacet";
  });
  std::string floats, faces, stl(80, ' ');
  for (int i = 0; i < kCount; ++i) {
    for (const int value : {i, i * i % 97, 1}) test::append<float>(floats, value);
    faces += '\3';
    for (int k = 0; k < 3; ++k) test::append<std::int32_t>(faces, (i + k) % kCount);
  }
  test::append<std::uint32_t>(stl, kCount);
  for (int i = 0; i < kCount; ++i) {
    for (int k = 0; k < 12; ++k) test::append<float>(stl, (i + k * k) % 101);
    stl += std::string(2, '\0');
  }
  const std::string ply = " 1.0\nelement vertex " + count +
                          "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                          count + "\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string pcd =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + count + "\nHEIGHT 1\nDATA ";
  test::GlbParts glb;
  const std::size_t points = glb.add_accessor(floats + floats + floats, 5126, 3 * kCount, "VEC3");
  glb.json["nodes"] = {{{"mesh", 0}}};
  glb.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", points}}}}}}}};
  return {{"a.obj", lines(kCount, [](int i) { return "v " + point(i); }) +
                        lines(kCount, [](int i) { return "f " + triangle(i, 1); })},
          {"a.off", "OFF\n" + count + " " + count + " 0\n" + xyz + threes},
          {"text.ply", "ply\nformat ascii" + ply + xyz + threes},
          {"binary.ply", "ply\nformat binary_little_endian" + ply + floats + faces},
          {"text.stl", "solid a\n" + facets + "endsolid\n"},
          {"binary.stl", stl},
          {"a.glb", glb.glb()},
          {"a.xyz", xyz},
          {"a.pts", count + "\n" + xyz},
          {"a.ptx", "1\n" + count +
                        "\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n" + xyz},
          {"text.pcd", pcd + "ascii\n" + xyz},
          {"binary.pcd", pcd + "binary\n" + floats}};
}

// The share of its bytes that a reader counts.
double counted(FileBytes file) {
  double told = 0;
  Callbacks callbacks;
  callbacks.progress = [&](std::string_view, double fraction) { told = fraction; };
  // More than there are, so that counting too much is seen.
  ReadProgress progress(callbacks, 2 * file.bytes.size());
  file.progress = &progress;
  const FormatInfo& format = info_of(*format_of(file.name));
  if (format.read_mesh)
    (void)format.read_mesh(file);
  else
    (void)format.read_points(file);
  std::this_thread::sleep_for(std::chrono::milliseconds(21));  // then the last is told
  check_stop();
  return 2 * told;
}

TEST(ReadProgress, CountsEveryByteOfEveryFormat) {
  for (const ProgressFile& sample : progress_files()) {
    const double share = counted(test::file_of(sample.bytes, sample.name));
    EXPECT_GT(share, 0.8) << sample.name;  // but headers, and a last piece that is no whole one
    EXPECT_LE(share, 1.0) << sample.name;
  }
}

TEST(ReadProgress, CountsWhatIsReadOnceMoreForNormals) {
  const std::string text = progress_files().front().bytes;
  FileBytes file = test::file_of(text, "a.obj");
  file.split_normals_crease = true;
  EXPECT_NEAR(counted(file), 1, 1e-9);
}

TEST(ReadProgress, RisesToOneOnTheCallingThread) {
  const test::TemporaryFolder folder;
  test::WatchingHost host;
  const Callbacks callbacks = host.callbacks();
  for (const ProgressFile& sample : progress_files()) {
    const FileBytes file = test::file_of(sample.bytes, sample.name);
    const FileFormat format = *format_of(sample.name);
    const bool is_cloud = holds_points_only(format);
    if (is_cloud)
      (void)read_points(file, format, callbacks);
    else
      (void)read_mesh(file, format, callbacks);
    host.expect_good(sample.name);
    const std::filesystem::path path = folder.path() / sample.name;
    std::ofstream(path, std::ios::binary) << sample.bytes;
    if (is_cloud)
      (void)read_points(path, callbacks);
    else
      (void)read_mesh(path, {.callbacks = callbacks});
    host.expect_good(sample.name + " from disk");
  }
}

TEST(ReadProgress, TellsSharesBetweenAndStopsThere) {
  // One thread, which is slow where it asks, so that every piece is told.
  const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                            1);
  const std::string text = progress_files().front().bytes;
  std::vector<double> told;
  Callbacks callbacks;
  callbacks.progress = [&](std::string_view step, double fraction) {
    EXPECT_EQ(step, "read");
    told.push_back(fraction);
  };
  callbacks.cancelled = [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(21));
    return told.size() >= 4;
  };
  FileBytes file = test::file_of(text, "a.obj");
  ReadProgress progress(callbacks, file.bytes.size());
  file.progress = &progress;
  (void)test::message_of(ErrorCode::Cancelled, [&] {
    (void)read_obj(file, text.size() / 20);
    ADD_FAILURE();
  });
  ASSERT_EQ(told.size(), 4);
  for (std::size_t i = 1; i < told.size(); ++i) EXPECT_GT(told[i], told[i - 1]);
  EXPECT_LT(told.back(), 0.5);
}

TEST(ReadProgress, StopsAmongLinesThatSayNothing) {
  std::string text;
  for (int line = 0; line < 5000; ++line) text += "# nothing\n";
  Callbacks callbacks;
  callbacks.cancelled = [] { return true; };
  const HostScope host(callbacks);
  EXPECT_NE(
      test::message_of(ErrorCode::Cancelled, [&] { (void)read_off(test::file_of(text, "a.off")); }),
      "no error");
}

}  // namespace
}  // namespace planish
