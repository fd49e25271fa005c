#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "planish/core/json.h"

namespace planish::test {

/// A test with an empty folder of its own, which vanishes with it.
class FolderTest : public testing::Test {
 protected:
  FolderTest();
  ~FolderTest() override;

  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_ / name).string();
  }
  /// Writes a file into the folder and returns its path.
  std::string write(const std::string& name, const std::string& content) const;
  [[nodiscard]] std::string read(const std::string& name) const;
  [[nodiscard]] nlohmann::json read_json(const std::string& name) const;
  /// Names of everything in the folder, hidden things included, sorted.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] bool exists(const std::string& name) const;

 private:
  std::filesystem::path folder_;
};

/// Closed: the unit cube's corners, 8 vertices, 6 quads.
[[nodiscard]] std::string cube_obj();
/// Open: n x n quads over the unit square, with a bump, so that the solve has work to do.
[[nodiscard]] std::string bumpy_plate_obj(int n);
/// Closed, genus 1: n x n quads.
[[nodiscard]] std::string torus_obj(int n);

}  // namespace planish::test
