#include <gmock/gmock.h>

#include <regex>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "commands.h"
#include "planish/core/error.h"
#include "planish/job/page/page.h"

namespace planish::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

nlohmann::json head_of(const std::string& page, std::size_t number = 0) {
  std::size_t at = 0;
  for (std::size_t i = 0; i <= number; ++i) at = page.find("class=\"head\">", at) + 13;
  return nlohmann::json::parse(page.substr(at, page.find("</script>", at) - at));
}

class PageFile : public FolderTest {
 protected:
  ProcessResult fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", plate_, "--device", "cpu"});
    return run_planish(flags);
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(8));
};

TEST_F(PageFile, APageIsOutputEnough) {
  const ProcessResult result = fit({"--page", path("p.html")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("page"));
  EXPECT_THAT(names(), ElementsAre("p.html", "plate.obj"));
  const nlohmann::json head = head_of(read("p.html"));
  EXPECT_EQ(head["level"], 2);
  EXPECT_EQ(head["base"], 81);
}

TEST_F(PageFile, IsTheSameFromRunToRunWithoutTimes) {
  const std::vector<std::string> flags{"--page", path("p.html"), "--page-no-times", "-f"};
  ASSERT_EQ(fit(flags).exit_code, 0);
  const std::string first = read("p.html");
  ASSERT_EQ(fit(flags).exit_code, 0);
  EXPECT_EQ(read("p.html"), first);
  EXPECT_THAT(first, Not(HasSubstr("timing_ms")));
}

// With times everything else is the same.
TEST_F(PageFile, OnlyTimesDifferFromRunToRun) {
  const std::vector<std::string> flags{"--page", path("p.html"), "-f"};
  const auto without_times = [&] {
    EXPECT_EQ(fit(flags).exit_code, 0);
    std::string page = read("p.html");
    for (const char* part : {"<h3>Time</h3>[^\n]*?<h3>Warnings", "&#34;timing_ms&#34;: [^}]*\\}",
                             "&#34;memory&#34;: [^}]*\\}", "memory<td>[^<]*<"})
      page = std::regex_replace(page, std::regex(part), "");
    // The row of all jobs ends with the time.
    return std::regex_replace(page, std::regex("<td class=\"n\">[0-9.]+ m?s</tbody>"), "");
  };
  EXPECT_EQ(without_times(), without_times());
}

TEST_F(PageFile, AgreesWithTheReportAndDoesNotChangeIt) {
  // Fair surfaces have errors of rounding only, which depend on where they are taken.
  std::vector<std::string> flags = {"--interpolation", "progressive", "-o",
                                    path("p.glb"),     "--report",    path("alone.json")};
  ASSERT_EQ(fit(flags).exit_code, 0);
  flags.back() = path("r.json");
  flags.insert(flags.end(), {"--page", path("p.html"), "-f"});
  ASSERT_EQ(fit(flags).exit_code, 0);
  nlohmann::json alone = read_json("alone.json"), report = read_json("r.json");
  for (const char* key : {"solve", "surface", "outputs", "input"})
    EXPECT_EQ(alone[key], report[key]) << key;
  const nlohmann::json head = head_of(read("p.html"));
  const nlohmann::json& error = head["fields"][0];
  EXPECT_NEAR(error["largest"].get<double>(), report["solve"]["error"]["max"].get<double>(),
              1e-3 * error["largest"].get<double>());
  EXPECT_NEAR(head["fields"][1]["largest"].get<double>(),
              report["surface"]["max_normal_deviation"].get<double>(), 1e-4);
  EXPECT_EQ(head["worst"], report["solve"]["error"]["worst_vertex"]);
}

TEST_F(PageFile, IsRefusedBeforeTheWorkWhereItCannotBe) {
  EXPECT_THAT(fit({"--page", path("p.json")}).err, HasSubstr("a page is an .html file"));
  EXPECT_THAT(fit({"--page", path("p.html"), "--page-limit", "8X"}).err,
              HasSubstr("--page-limit: \"8X\" is no size"));
  write("old.html", "old");
  const ProcessResult result = fit({"--page", path("old.html")});
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_THAT(result.err, HasSubstr("exists; --force overwrites it"));
  EXPECT_EQ(read("old.html"), "old");
  EXPECT_THAT(fit({"--page", path("p.html"), "--report", path("p.html")}).err,
              HasSubstr("a report is JSON, and its name ends in .json"));
}

TEST_F(PageFile, GoesToStdout) {
  const ProcessResult result = fit({"--page", "-"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(result.out.starts_with("<!doctype html>"));
  EXPECT_TRUE(result.out.ends_with("</html>\n"));
}

TEST_F(PageFile, IsNamedByADryRun) {
  EXPECT_THAT(fit({"--page", path("p.html"), "--dry-run"}).out,
              HasSubstr("would write  " + path("p.html") + "  (page)"));
  EXPECT_FALSE(exists("p.html"));
}

TEST_F(PageFile, KeepsToItsLimit) {
  ASSERT_EQ(fit({"--page", path("p.html"), "--page-limit", "72K"}).exit_code, 0);
  EXPECT_LE(read("p.html").size(), 72u * 1024);
  EXPECT_THAT(read("p.html"), HasSubstr("larger than the page may be (72.0 KiB;"));
}

// A large mesh's page is made level by level, up to the first that does not fit.
TEST_F(PageFile, GrowsLevelByLevelOfALargeMesh) {
  const std::string plate = write("large.obj", bumpy_plate_obj(200));
  for (const auto& [limit, level] : {std::pair("500K", 0), {"900K", 1}, {"2M", 2}}) {
    const ProcessResult result = run_planish(
        {"fit", plate, "--device", "cpu", "--page", path("p.html"), "--page-limit", limit, "-f"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::string page = read("p.html"),
                      shown = "The view shows level " + std::to_string(level);
    EXPECT_EQ(head_of(page)["level"], level) << limit;
    EXPECT_EQ(head_of(page)["base"], 201 * 201);
    EXPECT_THAT(page, HasSubstr(level == 2 ? shown + "."
                                           : shown + ", because level " +
                                                 std::to_string(level + 1) + " is larger"));
  }
}

TEST_F(PageFile, ShowsWhatHasNotConverged) {
  const ProcessResult result =
      fit({"--page", path("p.html"), "--max-iterations", "0", "--interpolation", "progressive"});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(read("p.html"), HasSubstr("not converged: iteration-limit"));
  EXPECT_THAT(read("p.html"), HasSubstr("It misses them by up to"));
}

TEST_F(PageFile, TurnsModelsWhoseUpIsZ) {
  ASSERT_EQ(fit({"--page", path("p.html"), "--up", "z"}).exit_code, 0);
  EXPECT_EQ(head_of(read("p.html"))["up"], "z");
}

class PageOfAScene : public FolderTest {
 protected:
  void SetUp() override {
    write("plate.obj", bumpy_plate_obj(6));
    write("torus.obj", torus_obj(6));
    write("s.json", R"({"version": 1, "defaults": {"device": "cpu"}, "jobs": [
        {"name": "plate", "input": "plate.obj", "page": "own.html"},
        {"name": "fair", "input": "torus.obj", "interpolation": "fair"},
        {"name": "missing", "input": "missing.obj"}]})");
  }
};

TEST_F(PageOfAScene, HoldsAllJobsAndThoseThatFailed) {
  const ProcessResult result = run_planish({"run", path("s.json"), "--page", path("all.html")});
  EXPECT_EQ(result.exit_code, 8);
  const std::string page = read("all.html");
  EXPECT_EQ(head_of(page, 0)["name"], "plate");
  EXPECT_EQ(head_of(page, 1)["label"], "fair");
  EXPECT_THAT(page, HasSubstr("missing.obj: cannot read"));
  EXPECT_THAT(page, HasSubstr("1 of 3 jobs has failed"));
  EXPECT_EQ(head_of(read("own.html"))["name"], "plate");
  EXPECT_THAT(result.err, HasSubstr("page of 3 jobs"));
}

TEST_F(PageOfAScene, OnStdoutStandsAlone) {
  const ProcessResult result = run_planish({"run", path("s.json"), "plate", "--page", "-", "-q"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.out.starts_with("<!doctype html>"));
  EXPECT_TRUE(result.out.ends_with("</html>\n"));
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
