#pragma once

#include <string>

namespace planish {

/// A setting as it was given: its name as in a scene file, the place ("--solver",
/// "scene.json:9: jobs[0].solve.solver") and the value as text.
struct GivenSetting {
  std::string name, where, value;
};

}  // namespace planish
