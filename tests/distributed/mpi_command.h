#pragma once

#include <string>
#include <vector>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {

/// A folder with a torus of 256 vertices, and planish-mpi as people start it.
class MpiCommand : public FolderTest {
 protected:
  /// `fault`: "rank:phase"; `before`: flags and programs between mpirun and planish-mpi.
  [[nodiscard]] static ProcessResult on(int ranks, std::vector<std::string> arguments,
                                        const std::string& fault = {},
                                        const std::vector<std::string>& before = {});
  /// planish on one machine; its exit code.
  [[nodiscard]] int planish(const std::string& arguments) const;

  std::string torus_ = write("torus.obj", torus_obj(16));
};

}  // namespace planish::test
