#include <gmock/gmock.h>

#include <regex>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "commands.h"
#include "planish/core/error.h"
#include "planish/job/page/page.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

json head_of(const std::string& page, std::size_t number = 0) {
  std::size_t at = 0;
  for (std::size_t i = 0; i <= number; ++i) at = page.find("class=\"head\">", at) + 13;
  return json::parse(page.substr(at, page.find("</script>", at) - at));
}

class PageFile : public FolderTest {
 protected:
  // The page of a fit of the plate.
  std::string page(const std::string& flags = "", int exit_code = 0) {
    run("fit plate.obj --page p.html -f " + flags, exit_code);
    return read("p.html");
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(8));
};

TEST_F(PageFile, APageIsOutputEnough) {
  const json head = head_of(page());
  EXPECT_THAT(said_, HasSubstr("page"));
  EXPECT_THAT(names(), ElementsAre("p.html", "plate.obj"));
  expect_values(head, {{"/level", 2}, {"/base", 81}});
  EXPECT_EQ(head_of(page("--up z"))["up"], "z");
}

TEST_F(PageFile, IsTheSameFromRunToRunWithoutTimes) {
  const std::string first = page("--page-no-times");
  EXPECT_EQ(page("--page-no-times"), first);
  EXPECT_THAT(first, Not(HasSubstr("timing_ms")));
}

// With times everything else is the same.
TEST_F(PageFile, OnlyTimesDifferFromRunToRun) {
  const auto without_times = [&] {
    std::string text = page();
    for (const char* part : {"<h3>Time</h3>[^\n]*?<h3>Warnings", "&#34;timing_ms&#34;: [^}]*\\}",
                             "&#34;memory&#34;: [^}]*\\}", "memory<td>[^<]*<",
                             // The row of all jobs ends with the time.
                             "<td class=\"n\">[0-9.]+ m?s</tbody>"})
      text = std::regex_replace(text, std::regex(part), "");
    return text;
  };
  EXPECT_EQ(without_times(), without_times());
}

TEST_F(PageFile, AgreesWithTheReportAndDoesNotChangeIt) {
  // Fair surfaces have errors of rounding only, which depend on where they are taken.
  const std::string line = "fit plate.obj --interpolation progressive -o p.glb";
  const json alone = report_of(line), report = report_of(line + " --page p.html");
  for (const char* key : {"solve", "surface", "outputs", "input"})
    EXPECT_EQ(alone[key], report[key]) << key;
  const json head = head_of(read("p.html"));
  const json& error = head["fields"][0];
  EXPECT_NEAR(error["largest"].get<double>(), report["solve"]["error"]["max"].get<double>(),
              1e-3 * error["largest"].get<double>());
  EXPECT_NEAR(head["fields"][1]["largest"].get<double>(),
              report["surface"]["max_normal_deviation"].get<double>(), 1e-4);
  EXPECT_EQ(head["worst"], report["solve"]["error"]["worst_vertex"]);
}

TEST_F(PageFile, KeepsToItsLimit) {
  const std::string text = page("--page-limit 72K");
  EXPECT_LE(text.size(), 72u * 1024);
  EXPECT_THAT(text, HasSubstr("larger than the page may be (72.0 KiB;"));
}

// A large mesh's page is made level by level, up to the first that does not fit.
TEST_F(PageFile, GrowsLevelByLevelOfALargeMesh) {
  write("plate.obj", bumpy_plate_obj(200));
  const std::string shown = "The view shows level ";
  for (const auto& [limit, level, said] : {std::tuple{"500K", 0, "0, because level 1 is larger"},
                                           {"900K", 1, "1, because level 2 is larger"},
                                           {"2M", 2, "2."}}) {
    const std::string text = page(std::string("--page-limit ") + limit);
    EXPECT_EQ(head_of(text)["level"], level) << limit;
    EXPECT_EQ(head_of(text)["base"], 201 * 201);
    EXPECT_THAT(text, HasSubstr(shown + said));
  }
}

TEST_F(PageFile, ShowsWhatHasNotConverged) {
  const std::string text = page("--max-iterations 0 --interpolation progressive", 5);
  EXPECT_THAT(text, HasSubstr("not converged: iteration-limit"));
  EXPECT_THAT(text, HasSubstr("It misses them by up to"));
}

TEST_F(PageFile, OfASceneHoldsAllJobsAndThoseThatFailed) {
  write("torus.obj", torus_obj(6));
  write("s.json", R"({"version": 1, "jobs": [
      {"name": "plate", "input": "plate.obj", "page": "own.html"},
      {"name": "fair", "input": "torus.obj", "interpolation": "fair"},
      {"name": "missing", "input": "missing.obj"}]})");
  run("run s.json --page all.html", 8);
  EXPECT_THAT(said_, HasSubstr("page of 3 jobs"));
  const std::string text = read("all.html");
  EXPECT_EQ(head_of(text, 0)["name"], "plate");
  EXPECT_EQ(head_of(text, 1)["label"], "fair");
  EXPECT_THAT(text, HasSubstr("missing.obj: cannot read"));
  EXPECT_THAT(text, HasSubstr("1 of 3 jobs has failed"));
  EXPECT_EQ(head_of(read("own.html"))["name"], "plate");
  // On stdout it stands alone.
  for (const char* line : {"fit plate.obj --page -", "run s.json plate --page - -q -f"}) {
    const std::string out = run(line).out;
    EXPECT_TRUE(out.starts_with("<!doctype html>"));
    EXPECT_TRUE(out.ends_with("</html>\n"));
  }
}

// A folder: a page of each file, and of several a contact sheet.
TEST_F(PageFile, AFolderHasAPageOfEachAndAContactSheet) {
  write("torus#1.obj", torus_obj(6));
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  run("fit plate.obj torus#1.obj bad.obj --page pages/", 8);
  EXPECT_THAT(said_, HasSubstr("pages/index.html: "));
  EXPECT_THAT(said_, HasSubstr("contact sheet of 3 files"));
  const std::string sheet = read("pages/index.html");
  EXPECT_THAT(sheet, HasSubstr("1 failed or not converged, the worst first"));
  EXPECT_THAT(sheet, HasSubstr("<a href=\"torus%231.html\">torus#1</a>"));
  EXPECT_THAT(sheet, HasSubstr("failed: bad.obj:2: "));
  const auto at = [&](const char* text) { return sheet.find(text); };
  EXPECT_LT(at(">bad<"), at(">plate<"));
  std::size_t pictures = 0;
  for (std::size_t i = sheet.find("<img"); i != std::string::npos; i = sheet.find("<img", i + 1))
    ++pictures;
  EXPECT_EQ(pictures, 4u);
  EXPECT_EQ(head_of(read("pages/plate.html"))["name"], "plate");
  EXPECT_EQ(head_of(read("pages/torus#1.html"))["name"], "torus#1");
  EXPECT_FALSE(std::filesystem::exists(path("pages/bad.html")));
  // As with -o, a name without an extension will be a folder.
  run("fit plate.obj torus#1.obj --page new");
  EXPECT_TRUE(std::filesystem::exists(path("new/index.html")));
  // One file has its page alone.
  run("fit plate.obj --page one/");
  EXPECT_TRUE(std::filesystem::exists(path("one/plate.html")));
  EXPECT_FALSE(std::filesystem::exists(path("one/index.html")));
  run("fit plate.obj torus#1.obj --page pages/", 7);
  EXPECT_THAT(said_, HasSubstr("pages/index.html exists; --force overwrites it"));
  run("fit plate.obj torus#1.obj --page pages/ --dry-run -f");
  EXPECT_THAT(run("fit plate.obj torus#1.obj --page pages/ --dry-run -f").out,
              HasSubstr("would write  pages/index.html  (page of all jobs)"));
}

// The jobs of a scene as files are; a page that has its place in the scene stays there.
TEST_F(PageFile, AFolderHasAContactSheetOfAScene) {
  write("torus.obj", torus_obj(6));
  write("s.json", R"({"version": 1, "jobs": [
      {"name": "a/plate", "input": "plate.obj"},
      {"name": "torus", "input": "torus.obj", "page": "own.html"},
      {"name": "missing", "input": "missing.obj"}]})");
  run("run s.json --page pages/", 8);
  EXPECT_THAT(said_, HasSubstr("contact sheet of 3 jobs"));
  const std::string sheet = read("pages/index.html");
  EXPECT_THAT(sheet, HasSubstr("<a href=\"a_plate.html\">a/plate</a>"));
  EXPECT_THAT(sheet, HasSubstr("<a href=\"../own.html\">torus</a>"));
  EXPECT_THAT(sheet, HasSubstr("failed: missing.obj: cannot read"));
  EXPECT_EQ(head_of(read("pages/a_plate.html"))["name"], "a/plate");
  EXPECT_TRUE(exists("own.html"));
  EXPECT_THAT(run("run s.json --page pages/ --dry-run -f", 8).out,
              HasSubstr("would write  pages/index.html  (page of all jobs)"));
}

TEST(PageFlags, SizesHaveUnits) {
  EXPECT_EQ(command::parse_page_limit("123", "x"), 123u);
  EXPECT_EQ(command::parse_page_limit("500K", "x"), 500u << 10);
  EXPECT_EQ(command::parse_page_limit("8M", "x"), 8u << 20);
  EXPECT_EQ(command::parse_page_limit("4G", "x"), std::uint64_t{4} << 30);
  for (const char* wrong : {"", "M", "-1", "8MB", "5G", "99999999999999999999", "1.5M", "8 M"})
    EXPECT_THROW((void)command::parse_page_limit(wrong, "x"), Error) << wrong;
}

}  // namespace
}  // namespace planish::test
