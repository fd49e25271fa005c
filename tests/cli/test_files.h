#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/planish_process.h"
#include "planish/core/json.h"
#include "support/files.h"

namespace planish::test {

/// A test with an empty folder of its own, which vanishes with it.
class FolderTest : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  /// Writes a file into the folder and returns its path.
  std::string write(const std::string& name, const std::string& content) const;
  [[nodiscard]] std::string read(const std::string& name) const;
  [[nodiscard]] nlohmann::json read_json(const std::string& name) const;
  /// Names of everything in the folder, hidden things included, sorted.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] bool exists(const std::string& name) const;

  /// Runs the command in the folder with the words of `line`, '' for an empty one. It has to end
  /// with that exit status. What it writes to stderr stays in `said_`.
  ProcessResult run(const std::string& line, int exit_code = 0,
                    PlanishProcess::Options options = {});
  /// What it prints.
  [[nodiscard]] nlohmann::json printed(const std::string& line, int exit_code = 0);
  /// The report of a fit, which it leaves in r.json, as its schema wants it.
  nlohmann::json report_of(const std::string& line, int exit_code = 0);

  /// Whether there is a device for Vulkan.
  [[nodiscard]] static bool has_vulkan();

  std::string said_;

 private:
  TemporaryFolder folder_;
};

/// What the published schema does not allow of a report, or of that form of one.
[[nodiscard]] std::vector<std::string> report_problems(const nlohmann::json& report,
                                                       const std::string& form = "");

/// Wants each value at its place: {{"/input/vertices", 8}, {"/exit_code", 0}}.
void expect_values(const nlohmann::json& found, const nlohmann::json& wanted);

[[nodiscard]] std::vector<std::string> words_of(const std::string& text);
[[nodiscard]] std::vector<std::string> lines_of(const std::string& text);

/// Closed: the unit cube's corners, 8 vertices, 6 quads.
[[nodiscard]] std::string cube_obj();
/// Open: n x n quads over the unit square, with a bump, so that the solve has work to do.
[[nodiscard]] std::string bumpy_plate_obj(int n);
/// Closed, genus 1: n x n quads.
[[nodiscard]] std::string torus_obj(int n);

}  // namespace planish::test
