#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {

// A unit sphere whose triangles are long and thin in places: rings at random heights, each turned
// at random.
inline std::string uneven_sphere_obj() {
  constexpr int kRings = 20, kSegments = 20;
  std::mt19937 random(11);
  const auto unit = [&] { return random() * 0x1p-32; };
  std::ostringstream obj;
  obj.precision(17);
  obj << "v 0 0 -1\n";
  for (int ring = 0; ring < kRings; ++ring) {
    const double z = -0.95 + 1.9 * (ring + 0.8 * unit()) / kRings;
    for (int segment = 0; segment < kSegments; ++segment) {
      const double angle = 2 * M_PI * (segment + 0.9 * unit()) / kSegments;
      const double radius = std::sqrt(1 - z * z);
      obj << "v " << radius * std::cos(angle) << ' ' << radius * std::sin(angle) << ' ' << z
          << '\n';
    }
  }
  obj << "v 0 0 1\n";
  const auto at = [](int ring, int segment) {
    return std::to_string(2 + ring * kSegments + segment % kSegments);
  };
  for (int s = 0; s < kSegments; ++s) {
    obj << "f 1 " << at(0, s + 1) << ' ' << at(0, s) << '\n';
    for (int r = 0; r + 1 < kRings; ++r) {
      obj << "f " << at(r, s) << ' ' << at(r, s + 1) << ' ' << at(r + 1, s + 1) << '\n';
      obj << "f " << at(r, s) << ' ' << at(r + 1, s + 1) << ' ' << at(r + 1, s) << '\n';
    }
    obj << "f " << at(kRings - 1, s) << ' ' << at(kRings - 1, s + 1) << ' '
        << 2 + kRings * kSegments << '\n';
  }
  return obj.str();
}

class Fair : public FolderTest {
 protected:
  // The report of a fit of `input`.
  nlohmann::json fit(const std::string& input, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", input, "--report", path("r.json"), "-f"});
    const ProcessResult result = run_planish(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    messages_ = result.err;
    return read_json("r.json");
  }

  std::string sphere_ = write("sphere.obj", uneven_sphere_obj());
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
  std::string messages_;
};

}  // namespace planish::test
