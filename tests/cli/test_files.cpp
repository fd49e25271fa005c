#include "cli/test_files.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "cli/json_schema.h"

namespace planish::test {
namespace fs = std::filesystem;

std::string FolderTest::write(const std::string& name, const std::string& content) const {
  const fs::path file = folder_.path() / name;
  fs::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  if (!stream) throw std::runtime_error("cannot write " + file.string());
  return file.string();
}

std::string FolderTest::read(const std::string& name) const {
  std::ifstream stream(folder_.path() / name, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

nlohmann::json FolderTest::read_json(const std::string& name) const {
  return nlohmann::json::parse(read(name));
}

std::vector<std::string> FolderTest::names() const {
  std::vector<std::string> result;
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    result.push_back(entry.path().filename().string());
  }
  std::ranges::sort(result);
  return result;
}

bool FolderTest::exists(const std::string& name) const { return fs::exists(folder_.path() / name); }

ProcessResult FolderTest::run(const std::string& line, int exit_code,
                              PlanishProcess::Options options) {
  std::vector<std::string> words = words_of(line);
  for (std::string& word : words)
    if (word == "''") word.clear();
  options.folder = path("");
  ProcessResult result = run_planish(words, options);
  EXPECT_EQ(result.exit_code, exit_code) << line << '\n' << result.err;
  said_ = result.err;
  return result;
}

nlohmann::json FolderTest::printed(const std::string& line, int exit_code) {
  return nlohmann::json::parse(run(line, exit_code).out);
}

nlohmann::json FolderTest::report_of(const std::string& line, int exit_code) {
  run(line + " --report r.json -f", exit_code);
  nlohmann::json report = read_json("r.json");
  EXPECT_EQ(report_problems(report), std::vector<std::string>()) << line;
  return report;
}

bool FolderTest::has_vulkan() {
  return run_planish({"fit", "-", "-o", "-", "--device", "vulkan"}, {.input = cube_obj()})
             .exit_code != 6;
}

std::vector<std::string> report_problems(const nlohmann::json& report, const std::string& form) {
  std::ifstream file(PLANISH_REPORT_SCHEMA);
  const auto schema = nlohmann::json::parse(file);
  return form.empty() ? schema_problems(report, schema)
                      : schema_problems(report, {{"$ref", "#/$defs/" + form}}, schema);
}

void expect_values(const nlohmann::json& found, const nlohmann::json& wanted) {
  for (const auto& [place, value] : wanted.items()) {
    const nlohmann::json::json_pointer pointer(place);
    EXPECT_EQ(found.contains(pointer) ? found[pointer] : nlohmann::json("not there"), value)
        << place;
  }
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

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
