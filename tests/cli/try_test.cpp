#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/files/mesh_file.h"
#include "support/cut_quads.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using nlohmann::json;

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;

std::string unescaped(std::string text) {
  for (const auto& [code, sign] : std::map<std::string, std::string>{
           {"&#34;", "\""}, {"&#39;", "'"}, {"&#60;", "<"}, {"&#62;", ">"}, {"&#38;", "&"}})
    text = std::regex_replace(text, std::regex(code), sign);
  return text;
}

// What the page says of a surface that may be kept.
struct Kept {
  std::string title, command, scene;
};

// The text of the next element, whose beginning is given up to its attributes; moves on to it.
std::string next_text(const std::string& page, std::size_t& at, const std::string& begin) {
  at = page.find('>', page.find(begin, at)) + 1;
  return unescaped(page.substr(at, page.find('<', at) - at));
}

std::vector<Kept> kept_of(const std::string& page) {
  std::vector<Kept> all;
  const std::string begin = "<section class=\"keep\"";
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, at)) {
    const std::string title = next_text(page, at, "<h2");
    const std::string command = next_text(page, at, "<pre");
    all.push_back({title, command, next_text(page, at, "<pre")});
  }
  return all;
}

class Try : public FolderTest {
 protected:
  Try() {
    write_mesh(path("torus.obj"), FileFormat::Obj, cut_quads(torus(16, 8, 1, 0.4)));
    write_mesh(path("box.obj"), FileFormat::Obj, cut_quads(cube()));
  }
  // Surfaces that were written, by name.
  std::map<std::string, std::string> surfaces(const std::string& folder) const {
    std::map<std::string, std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(path(folder)))
      if (entry.path().extension() == ".glb")
        all[entry.path().stem().string()] = read(folder + entry.path().filename().string());
    return all;
  }
};

TEST_F(Try, CommandLineAndSceneGiveTheSurfaceThatIsKept) {
  for (const auto& [input, flags] : std::map<std::string, std::string>{
           {"torus", "--levels 1 --up z --device cpu"}, {"box", ""}}) {
    SCOPED_TRACE(input + " " + flags);
    run("try " + input + ".obj -o tried/ -f --page-limit 1K " + flags);
    EXPECT_THAT(said_, AllOf(HasSubstr("  taken\n"), HasSubstr("tried/index.html")));
    const auto written = surfaces("tried/");
    const std::vector<Kept> kept = kept_of(read("tried/index.html"));
    ASSERT_GE(kept.size(), 4u);
    ASSERT_EQ(kept.size(), written.size());
    std::set<std::string> seen;
    for (const Kept& one : kept) {
      SCOPED_TRACE(one.command);
      ASSERT_TRUE(one.command.starts_with("planish fit " + input + ".obj -o " + input + ".glb"));
      run(one.command.substr(8) + " -f -q");
      const std::string by_line = read(input + ".glb");
      const auto same = std::ranges::find_if(
          written, [&](const auto& surface) { return surface.second == by_line; });
      ASSERT_NE(same, written.end());
      seen.insert(same->first);
      write("s.json", one.scene);
      run("run s.json -f -q");
      EXPECT_EQ(read(input + ".glb"), by_line);
    }
    EXPECT_EQ(seen.size(), written.size()) << "each by its own line";
    // The first is what comes without a choice.
    run("fit " + input + ".obj -o own.glb -f -q " + flags);
    run(kept.front().command.substr(8) + " -f -q");
    EXPECT_EQ(read(input + ".glb"), read("own.glb"));
    std::filesystem::remove_all(path("tried"));
  }
}

TEST_F(Try, WritesAPageAloneOrATable) {
  run("try torus.obj --page p.html");
  EXPECT_THAT(said_, HasSubstr("p.html"));
  const std::string page = read("p.html");
  for (const char* part :
       {"taken by default", "--quads on", "<tr data-job=\"0\">", "class=\"card\""})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(names(), ElementsAre("box.obj", "p.html", "torus.obj"));
  run("try torus.obj");
  EXPECT_THAT(said_, AllOf(HasSubstr("--quads off"), HasSubstr("cost")));
  EXPECT_EQ(names().size(), 3u);
  run("try torus.obj --page p.html", 7);
  EXPECT_THAT(said_, HasSubstr("p.html"));
  run("try torus.obj --page q.html --page-limit 1K --page-no-times -f -q");
  const std::string first = read("q.html");
  run("try torus.obj --page q.html --page-limit 1K --page-no-times -f -q");
  EXPECT_EQ(read("q.html"), first);
  EXPECT_EQ(run("try torus.obj --page - --page-limit 1K -q").out.substr(0, 15), "<!doctype html>");
}

TEST_F(Try, AReportSaysWhatMakesEach) {
  run("try torus.obj --report tried.json -o tried/ --page-limit 1K -q");
  const json report = read_json("tried.json");
  const auto written = surfaces("tried/");
  EXPECT_THAT(report_problems(report, "try"), IsEmpty());
  ASSERT_EQ(report["surfaces"].size(), written.size());
  for (const json& one : report["surfaces"]) {
    SCOPED_TRACE(one.dump());
    std::string flags;
    for (const auto& [name, value] : one["settings"].items())
      flags += " --" + name + " " + value.get<std::string>();
    run("fit torus.obj -o torus.glb -f -q" + flags);
    EXPECT_EQ(read("torus.glb"), read(one["file"].get<std::string>()));
    EXPECT_EQ(one["taken"], one == report["surfaces"][0]);
  }
  const std::string out = run("try torus.obj --report - -q").out;
  const json alone = json::parse(out);
  EXPECT_EQ(alone["surfaces"][0]["file"], json());
  EXPECT_EQ(alone["surfaces"][0]["cost"], report["surfaces"][0]["cost"]);
  run("try torus.obj --report - --page - -q", 2);
  run("try torus.obj --report tried.json -q", 7);
}

TEST_F(Try, FlagsNarrowWhatIsTried) {
  run("try torus.obj --page p.html --page-limit 1K --interpolation fair --quads off -q");
  for (const Kept& one : kept_of(read("p.html"))) {
    EXPECT_THAT(one.command, HasSubstr("--interpolation fair --quads off"));
    EXPECT_THAT(one.title, Not(HasSubstr("quads")));
  }
}

TEST_F(Try, SaysWhatIsWrongAndWhatToDo) {
  run("try missing.obj", 3);
  EXPECT_THAT(said_, HasSubstr("missing.obj"));
  write("bad.obj", "v 0 0 0\nv 1 0 x\n");
  run("try bad.obj", 3);
  EXPECT_THAT(said_, HasSubstr("bad.obj:2"));
  write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  run("try flat.obj", 4);
  run("try torus.obj --scheme loop", 2);
  EXPECT_THAT(said_, HasSubstr("leave --scheme out"));
  run("try torus.obj --quads on --creases use --interpolation fair", 2);
  EXPECT_THAT(said_, HasSubstr("nothing is left to try"));
  run("try torus.obj --levels 2,1", 2);
  EXPECT_THAT(said_, HasSubstr("--levels: surfaces are tried with one fineness each"));
  run("try - -q", 2);
  EXPECT_THAT(said_, HasSubstr("name a file"));
  run("try torus.obj -o t.glb", 2);
  EXPECT_THAT(said_, AllOf(HasSubstr("-o: t.glb: is no folder"), HasSubstr("-o t/")));
  write("cloud.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n");
  run("try cloud.ply", 2);
  EXPECT_THAT(said_, AllOf(HasSubstr("cloud.ply: holds points"), HasSubstr("planish reconstruct")));
  EXPECT_THAT(names(), Not(Contains("t.glb")));
}

}  // namespace
}  // namespace planish::test
