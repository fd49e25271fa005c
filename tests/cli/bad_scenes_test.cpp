#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

struct ExitCodes {
  int repaired, refused;
};

// The table in scenes/README.md: what users are told is what is tested.
std::map<std::string, ExitCodes> promised_exit_codes() {
  std::ifstream readme(std::string(PLANISH_SCENES) + "/README.md");
  const std::regex row("\\| `([^`]+)` \\| (\\d) \\| (\\d) \\|.*");
  std::map<std::string, ExitCodes> promised;
  std::smatch match;
  for (std::string line; std::getline(readme, line);) {
    if (std::regex_match(line, match, row)) {
      promised[match[1]] = {std::stoi(match[2]), std::stoi(match[3])};
    }
  }
  return promised;
}

class BadScenes : public FolderTest {};

TEST_F(BadScenes, EndAsTheirReadmeSays) {
  const auto promised = promised_exit_codes();
  std::size_t count = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(std::string(PLANISH_SCENES) + "/bad")) {
    const std::string name = file.path().filename().string();
    ++count;
    ASSERT_TRUE(promised.contains(name)) << name << " is not in scenes/README.md";
    const ProcessResult repaired =
        run_planish({"fit", file.path().string(), "-o", path("a.glb"), "-f"});
    EXPECT_EQ(repaired.exit_code, promised.at(name).repaired) << name << ": " << repaired.err;
    EXPECT_FALSE(repaired.err.empty()) << name << " needs an error or a warning";
    EXPECT_EQ(exists("a.glb"), repaired.exit_code == 0) << name;
    std::filesystem::remove(path("a.glb"));
    const ProcessResult refused =
        run_planish({"fit", file.path().string(), "-o", path("a.glb"), "--repair", "none"});
    EXPECT_EQ(refused.exit_code, promised.at(name).refused) << name << ": " << refused.err;
    std::filesystem::remove(path("a.glb"));
  }
  EXPECT_EQ(count, promised.size());
}

class SharpScenes : public FolderTest {};

TEST_F(SharpScenes, ACubeWithHolesKeepsItsPlanesAndEdges) {
  const std::string cube = std::string(PLANISH_SCENES) + "/cube_with_holes.obj";
  const ProcessResult result = run_planish(
      {"fit", cube, "--creases", "auto", "-o", path("c.ply"), "--report", path("c.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json report = read_json("c.json");
  EXPECT_EQ(report["solve"]["iterations"], 0);
  EXPECT_LT(report["solve"]["error"]["max"], 1e-6);
  EXPECT_EQ(report["surface"]["folded_area"], 0.0);
  EXPECT_GT(report["input"]["corners"], 0);
}

}  // namespace
}  // namespace planish::test
