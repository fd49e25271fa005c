// SPDX-License-Identifier: GPL-3.0-or-later
// planish-reconstruct: points on standard input, triangles on standard output, as
// mesher_protocol.h says. `planish fit` and `planish reconstruct` start it.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/mesh/check.h"
#include "planish/reconstruct/cgal/advancing_front.h"
#include "planish/reconstruct/mesher_protocol.h"

namespace planish {
namespace {

constexpr std::string_view kUsage =
    "planish-reconstruct: meshes points for planish fit and planish reconstruct, which start it.\n"
    "It reads points from standard input and writes triangles to standard output, both binary.\n"
    "Flags: --help, --version. Licence: GPL-3.0-or-later, for it is built with CGAL.\n";

struct BrokenPipe {};

void write_bytes(const void* data, std::size_t size) {
  if (std::fwrite(data, 1, size, stdout) != size) throw BrokenPipe();
}

template <class Payload>
void write_message(char kind, Payload payload) {
  static_assert(sizeof payload == 8);
  write_bytes(&kind, 1);
  write_bytes(&payload, sizeof payload);
}

void flush() {
  if (std::fflush(stdout) != 0) throw BrokenPipe();
}

std::vector<glm::dvec3> read_points() {
  constexpr std::size_t kSlice = 1 << 16;
  const auto fail = [](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, "planish-reconstruct: standard input " + what);
  };
  std::array<char, 8> magic{};
  std::int64_t count = 0;
  if (std::fread(magic.data(), 1, magic.size(), stdin) != magic.size() || magic != kMesherMagic)
    fail("does not begin as planish begins it");
  if (std::fread(&count, sizeof count, 1, stdin) != 1 || count < 0 || count > INT32_MAX)
    fail("names no number of points below 2^31");
  std::vector<glm::dvec3> points;
  while (points.size() < static_cast<std::size_t>(count)) {
    // In slices: a number alone takes no memory.
    const std::size_t had = points.size();
    points.resize(had + std::min(kSlice, static_cast<std::size_t>(count) - had));
    const std::size_t wanted = points.size() - had;
    if (std::fread(points.data() + had, sizeof(glm::dvec3), wanted, stdin) != wanted)
      fail(formatted("ends before point {}", count));
  }
  for (const glm::dvec3& point : points)
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(point[axis]) <= kMaxCoordinate)) fail("has a point that is not finite");
  return points;
}

void write_failure(ErrorCode code, std::string_view text) {
  write_message(kMesherFailure, static_cast<std::int64_t>(text.size()));
  const auto number = static_cast<std::int32_t>(code);
  write_bytes(&number, sizeof number);
  write_bytes(text.data(), text.size());
  flush();
}

void mesh_points() {
  const std::vector<glm::dvec3> points = read_points();
  Callbacks callbacks;
  callbacks.progress = [](std::string_view, double fraction) {
    write_message(kMesherProgress, fraction);
    flush();
  };
  const auto answer = [](const std::vector<Triangle>& triangles) {
    write_message(kMesherTriangles, static_cast<std::int64_t>(triangles.size()));
    write_bytes(triangles.data(), triangles.size() * sizeof(Triangle));
    flush();
  };
  advance_front(points, answer, callbacks);
}

int run() {
  try {
    mesh_points();
    return 0;
  } catch (const std::exception&) {
    const Failure failure = current_failure("planish-reconstruct: memory does not suffice");
    if (failure.code)
      write_failure(*failure.code, failure.message);
    else
      write_failure(ErrorCode::UnusableMesh, formatted("planish-reconstruct: {}", failure.message));
  }
  return 1;
}

}  // namespace
}  // namespace planish

int main(int count, char** arguments) {
  if (count > 1) {
    const std::string_view flag = arguments[1];
    if (flag == "--version") {
      std::printf("planish-reconstruct %s\n", PLANISH_VERSION);
      return 0;
    }
    const bool help = count == 2 && (flag == "--help" || flag == "-h");
    std::fputs(planish::kUsage.data(), help ? stdout : stderr);
    return help ? 0 : 2;
  }
  try {
    return planish::run();
  } catch (const planish::BrokenPipe&) {
    return 7;  // nobody listens any more
  }
}
