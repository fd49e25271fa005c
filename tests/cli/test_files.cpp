#include "cli/test_files.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace planish::test {
namespace fs = std::filesystem;

FolderTest::FolderTest() {
  std::string name = (fs::temp_directory_path() / "planish_cli_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  folder_ = name;
}

FolderTest::~FolderTest() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string FolderTest::write(const std::string& name, const std::string& content) const {
  const fs::path file = folder_ / name;
  fs::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  if (!stream) throw std::runtime_error("cannot write " + file.string());
  return file.string();
}

std::string FolderTest::read(const std::string& name) const {
  std::ifstream stream(folder_ / name, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

nlohmann::json FolderTest::read_json(const std::string& name) const {
  return nlohmann::json::parse(read(name));
}

std::vector<std::string> FolderTest::names() const {
  std::vector<std::string> result;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    result.push_back(entry.path().filename().string());
  }
  std::ranges::sort(result);
  return result;
}

bool FolderTest::exists(const std::string& name) const { return fs::exists(folder_ / name); }

std::string cube_obj() {
  return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
         "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
}

std::string bumpy_plate_obj(int n) {
  std::ostringstream obj;
  obj.precision(17);
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      const double u = static_cast<double>(x) / n, v = static_cast<double>(y) / n;
      obj << "v " << u << ' ' << v << ' ' << 0.2 * std::sin(7 * u) * std::cos(5 * v) << '\n';
    }
  }
  const auto at = [n](int x, int y) { return y * (n + 1) + x + 1; };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      obj << "f " << at(x, y) << ' ' << at(x + 1, y) << ' ' << at(x + 1, y + 1) << ' '
          << at(x, y + 1) << '\n';
    }
  }
  return obj.str();
}

std::string torus_obj(int n) {
  std::ostringstream obj;
  obj.precision(17);
  constexpr double kTurn = 2 * std::numbers::pi;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double u = kTurn * i / n, v = kTurn * j / n;
      const double radius = 1 + 0.4 * std::cos(v);
      obj << "v " << radius * std::cos(u) << ' ' << radius * std::sin(u) << ' ' << 0.4 * std::sin(v)
          << '\n';
    }
  }
  const auto at = [n](int i, int j) { return (i % n) * n + j % n + 1; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      obj << "f " << at(i, j) << ' ' << at(i + 1, j) << ' ' << at(i + 1, j + 1) << ' '
          << at(i, j + 1) << '\n';
    }
  }
  return obj.str();
}

}  // namespace planish::test
