#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <regex>
#include <thread>
#include <utility>
#include <vector>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/job/job_text.h"
#include "terminal.h"

namespace planish::command {
namespace {

TEST(Text, NumbersSizesAndDurationsAreShort) {
  EXPECT_EQ(with_separators(0), "0");
  EXPECT_EQ(with_separators(999), "999");
  EXPECT_EQ(with_separators(1000), "1,000");
  EXPECT_EQ(with_separators(1234567), "1,234,567");
  EXPECT_EQ(with_separators(-123), "-123");
  EXPECT_EQ(with_separators(-1234), "-1,234");
  EXPECT_EQ(byte_size(1023), "1023 B");
  EXPECT_EQ(byte_size(1024), "1.0 KiB");
  EXPECT_EQ(byte_size(5ull << 30), "5.0 GiB");
  EXPECT_EQ(duration(0.26), "0.3 ms");
  EXPECT_EQ(duration(12.4), "12 ms");
  EXPECT_EQ(duration(1234), "1.23 s");
  EXPECT_EQ(short_number(4.123e-7), "4.12e-07");
  EXPECT_EQ(counted(1, "face"), "1 face");
  EXPECT_EQ(counted(0, "face"), "0 faces");
  EXPECT_EQ(counted(1200, "face"), "1,200 faces");
}

TEST(Text, PlainUtf8KeepsLettersAndDropsTheRest) {
  EXPECT_EQ(plain_utf8("K\xC3\xA4se \xF0\x9F\xA7\x80"), "K\xC3\xA4se \xF0\x9F\xA7\x80");
  EXPECT_EQ(plain_utf8("a\nb\x7F"), "a?b?");
  EXPECT_EQ(plain_utf8("\xC3"), "?");                 // cut short
  EXPECT_EQ(plain_utf8("\xFFz"), "?z");               // no UTF-8 at all
  EXPECT_EQ(plain_utf8("\xC0\x80"), "??");            // overlong
  EXPECT_EQ(plain_utf8("\xED\xA0\x80"), "???");       // a surrogate
  EXPECT_EQ(plain_utf8("\xF4\x90\x80\x80"), "????");  // beyond Unicode
}

TEST(Nearest, FindsSlipsAndLeavesOtherWordsAlone) {
  constexpr std::array<std::string_view, 4> kWords{"weights", "tolerance", "levels", "report"};
  EXPECT_EQ(nearest("wieghts", kWords), "weights");      // swapped
  EXPECT_EQ(nearest("tolerence", kWords), "tolerance");  // replaced
  EXPECT_EQ(nearest("level", kWords), "levels");         // missing
  EXPECT_EQ(nearest("reeport", kWords), "report");       // doubled
  EXPECT_EQ(nearest("banana", kWords), std::nullopt);
  EXPECT_EQ(nearest(std::string(100000, 'x'), kWords), std::nullopt);
  EXPECT_EQ(did_you_mean("banana", kWords), "");
}

TEST(Table, AlignsColumnsByCharacters) {
  Table table({{"name"}, {"count", Align::Right}});
  table.add_row({"K\xC3\xA4se", "7"});
  table.add_row({"a", "1,000"});
  EXPECT_EQ(table.text(), "name  count\nK\xC3\xA4se      7\na     1,000\n");
}

// What `work` writes to stderr with a clock that it sets.
template <class Work>
std::string output_of(ProgressMode mode, const Work& work) {
  testing::internal::CaptureStderr();
  {
    double now = 100;
    Console console(LogLevel::Info, ColorMode::Never);
    Progress all(
        console, mode, [&now] { return now; }, 3);
    JobDisplay display(all, "goblet", 2);
    JobProgress progress(display.visit());
    progress.plan({{"read", 1}, {"solve", 2}, {"evaluate", 1}, {"evaluate", 4}});
    work(progress, now);
    all.finish();
  }
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, PlainSpeaksAtMostEveryTenSeconds) {
  const std::string text = output_of(ProgressMode::Plain, [](JobProgress& progress, double& now) {
    for (int second = 0; second < 25; ++second) {
      now = 100 + second;
      progress.update("solve", second / 25.0);
    }
  });
  EXPECT_EQ(text, "goblet: 22%, solve, 34 s left\ngoblet: 32%, solve, 42 s left\n");
}

TEST(Progress, PlainIsSilentAboutShortWork) {
  EXPECT_EQ(output_of(ProgressMode::Plain,
                      [](JobProgress& progress, double&) { progress.update("solve", 1); }),
            "");
}

TEST(Progress, JsonHasOneLinePerStepAndPercent) {
  const std::string text =
      output_of(ProgressMode::JsonLines, [](JobProgress& progress, double& now) {
        progress.update("read", 0);
        progress.update("read", 0.001);
        now += 2;
        progress.update("solve", 0.5);
      });
  EXPECT_EQ(text,
            "{\"job\":\"goblet\",\"step\":\"read\",\"fraction\":0.0,\"number\":2,\"jobs\":3,"
            "\"share\":0.0,\"seconds\":0.0,\"seconds_left\":null}\n"
            "{\"job\":\"goblet\",\"step\":\"solve\",\"fraction\":0.5,\"number\":2,\"jobs\":3,"
            "\"share\":0.25,\"seconds\":2.0,\"seconds_left\":6.0}\n");
}

TEST(Progress, TheShareOfTheWholeNeverFalls) {
  std::vector<double> shares;
  (void)output_of(ProgressMode::None, [&](JobProgress& progress, double&) {
    for (const auto& [step, fraction] :
         std::vector<std::pair<const char*, double>>{{"read", 0},
                                                     {"solve", 0.5},
                                                     {"unknown", 1},
                                                     {"solve", 0.25},
                                                     {"evaluate", 0.5},
                                                     {"evaluate", 1},
                                                     {"evaluate", 0},
                                                     {"evaluate", 0.5},
                                                     {"evaluate", 1}}) {
      progress.update(step, fraction);
      shares.push_back(progress.share());
    }
  });
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares[5], 0.5);   // the first level of two, with a quarter of the second's weight
  EXPECT_EQ(shares[7], 0.75);  // half of the second
  EXPECT_EQ(shares.back(), 1);
}

TEST(Progress, WhatIsNotPlannedIsAPartOfTheStepUnderWay) {
  (void)output_of(ProgressMode::None, [&](JobProgress& progress, double&) {
    progress.update("read", 0);
    progress.update("solve", 0);
    progress.update("masks", 0.25);
    EXPECT_EQ(progress.share(), 1.5 / 8);
    progress.update("steps", 1);
    EXPECT_EQ(progress.share(), 3.0 / 8);
    progress.update("evaluate", 0);
    EXPECT_EQ(progress.share(), 3.0 / 8);
  });
}

TEST(Progress, TheBarIsDrawnInPlaceAndTakenAway) {
  const std::string text = output_of(ProgressMode::Bar, [](JobProgress& progress, double& now) {
    now += 1;
    progress.update("solve", 0.5);
  });
  EXPECT_EQ(text, "\r\033[K2/3 goblet  [######..................]  25%  solve, 3 s left\r\033[K");
}

TEST(Progress, AutoOutsideATerminalAndNoneSayNothing) {
  for (const auto& [mode, seconds] :
       {std::pair{ProgressMode::Auto, 1.0}, {ProgressMode::None, 100.0}})
    EXPECT_EQ(output_of(mode,
                        [wait = seconds](JobProgress& progress, double& now) {
                          now += wait;
                          progress.update("solve", 0.5);
                        }),
              "");
}

}  // namespace
}  // namespace planish::command

namespace planish::test {
namespace {

// What reaches a terminal, a pipe and another program.

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// No byte that a terminal obeys, but line ends.
bool is_plain(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte < 0x20 && byte != '\n') || byte == 0x7F) return false;
  }
  return text.find("\xE2\x80\xAE") == std::string::npos &&
         text.find("\xE2\x80\x8B") == std::string::npos;
}

const std::vector<std::string> kHostile{"\x1b[31mred",
                                        "two\nlines",
                                        "back\rhome",
                                        "ri\xE2\x80\xAEght",
                                        "no\xE2\x80\x8Bwidth",
                                        "bell\a",
                                        "\xFF\xFE",
                                        "del\x7F",
                                        "\xC2\x9B"
                                        "31m"};

class Messages : public FolderTest {
 protected:
  // Names may hold spaces and worse.
  [[nodiscard]] ProcessResult run_here(const std::vector<std::string>& arguments) const {
    return run_planish(arguments, {.folder = path("")});
  }
};

TEST_F(Messages, HostileNamesOfFilesAreShownNotObeyed) {
  write("good.obj", cube_obj());
  for (const std::string& name : kHostile) {
    const std::string file = name + ".obj";
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"fit", file, "-o", "x.glb"},
          {"fit", "good.obj", "-o", name + "/x.glb"},
          {"fit", "good.obj", "-o", name},
          {"fit", "good.obj", "-o", "x.glb", "--device", name},
          {"fit", "good.obj", "-o", "x.glb", "--solver", name},
          {"fit", "good.obj", "-o", "x.glb", "--" + name},
          {"verify", file, "good.obj"},
          {"run", file},
          {"inspect", file},
          {name}}) {
      const ProcessResult result = run_here(arguments);
      EXPECT_NE(result.exit_code, 0);
      EXPECT_TRUE(is_plain(result.err)) << result.err;
      EXPECT_EQ(result.out, "");
    }
    // No line is broken by the name: the friendly name gives as many.
    const auto lines = [&](const std::string& input) {
      return lines_of(run_here({"fit", input, "-o", "x.glb"}).err).size();
    };
    EXPECT_EQ(lines(file), lines("friendly.obj")) << name;
  }
}

TEST_F(Messages, HostileNamesThatWorkAreShownInSummaries) {
  const std::string name = "a\x1b[31m\nb.obj";
  write(name, cube_obj());
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"fit", name, "-o", "o\x1b[2J.glb", "--dry-run"},
        {"fit", name, "-o", "o\x1b[2J.glb"},
        {"inspect", name}}) {
    const ProcessResult result = run_here(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(is_plain(result.out + result.err)) << result.out << result.err;
    EXPECT_THAT(result.out + result.err, HasSubstr("a\\x1b[31m\\nb.obj"));
  }
}

TEST_F(Messages, NamesOfASceneAreShownNotObeyed) {
  write("cube.obj", cube_obj());
  write("s.json", R"({"version":1,"jobs":[{"name":"\u001b[31mred\nline\u202e","input":"cube.obj",)"
                  R"("outputs":[{"path":"x.glb"}]},{"name":"\u001b[0m","input":"none.obj"}]})");
  const std::string table = run("run s.json", 8).out;
  EXPECT_TRUE(is_plain(table)) << table;
  EXPECT_TRUE(is_plain(said_)) << said_;
  EXPECT_THAT(table, HasSubstr("\\x1b[31mred\\nline\\u202e"));
}

TEST_F(Messages, ErrorsObeyColor) {
  struct Row {
    std::string line;
    bool terminal;
    std::vector<std::string> environment;
    bool is_colored;
  };
  const std::string wrong = "fit none.obj -o x.glb --color ";
  for (const Row& row : std::vector<Row>{
           {wrong + "always", false, {}, true},
           {wrong + "never", true, {}, false},
           {wrong + "auto", true, {}, true},
           {wrong + "auto", false, {}, false},
           // What is set to nothing is not set (no-color.org).
           {wrong + "auto", true, {"NO_COLOR="}, true},
           {wrong + "auto", true, {"NO_COLOR=1"}, false},
           {"fti --color=always", false, {}, true},
       }) {
    SCOPED_TRACE(row.line);
    std::vector<std::string> environment = row.environment;
    environment.emplace_back("TERM=xterm");
    const std::string text = run(row.line, row.line.starts_with("fti") ? 2 : 3,
                                 {.terminal = row.terminal, .environment = environment})
                                 .out +
                             said_;
    EXPECT_EQ(text.find("\033[1;31merror") != std::string::npos, row.is_colored);
    EXPECT_EQ(text.find('\033') != std::string::npos, row.is_colored);
  }
}

TEST_F(Messages, BytesDoNotGoToATerminal) {
  write("cube.obj", cube_obj());
  const PlanishProcess::Options shown{.terminal = true, .environment = {"TERM=xterm"}};
  EXPECT_THAT(run("fit cube.obj -o -", 2, shown).out,
              AllOf(HasSubstr("not written to a terminal"), Not(HasSubstr("glTF"))));
  EXPECT_THAT(run("fit cube.obj --report - -q", 0, shown).out, HasSubstr("planish.report/1"));
}

TEST_F(Messages, AReaderThatLeavesEndsTheCommandSilently) {
  write("cube.obj", cube_obj());
  for (const char* line : {"fit cube.obj -o - --cage c.obj -q", "--help", "devices"}) {
    const ProcessResult result = run(line, -1, {.closed_stdout = true});
    EXPECT_EQ(result.signal, SIGPIPE) << line;
    EXPECT_EQ(said_, "");
  }
  EXPECT_EQ(names(), std::vector<std::string>{"cube.obj"});
}

TEST_F(Messages, AllThatIsWrongIsSaidAtOnceTheInputFirst) {
  write("old.glb", "precious");
  // The status is the lowest of theirs.
  run("fit GOBLET.OBJ -o old.glb --cage missing/c.obj --report r.html", 2);
  EXPECT_THAT(said_, testing::ContainsRegex("GOBLET.OBJ: cannot read(.|\n)*old.glb exists"));
  EXPECT_THAT(said_, AllOf(HasSubstr("no folder"), HasSubstr("ends in .json")));
  EXPECT_EQ(lines_of(said_).size(), 4u);
}

TEST_F(Messages, WithJsonProgressEveryLineIsAnObject) {
  write("cube.obj", cube_obj());
  write("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n");  // gives a warning
  for (const auto& [line, exit_code] : {std::pair{"fit two.obj -o x.glb --progress json", 0},
                                        {"fit none.obj -o y.glb --progress=json", 3},
                                        {"fit cube.obj two.obj -o out/ --progress json", 0}}) {
    run(line, exit_code);
    EXPECT_NE(said_, "");
    for (const std::string& said : lines_of(said_))
      EXPECT_TRUE(nlohmann::json::parse(said, nullptr, false).is_object()) << said;
  }
}

// The name that begins a message, and stands in it once.
void expect_named(const std::string& text, const std::string& name) {
  int count = 0;
  for (const std::string& line : lines_of(text)) {
    const bool is_message =
        line.starts_with("planish: warning: ") || line.starts_with("planish: error: ");
    if (!is_message || line.ends_with("jobs failed")) continue;
    const std::string said = line.substr(line.find(": ", line.find(": ") + 2) + 2);
    EXPECT_THAT(said, testing::StartsWith(name + ":")) << text;
    EXPECT_EQ(said.find(name, 1), std::string::npos) << text;
    EXPECT_THAT(said, Not(HasSubstr("-: "))) << text;
    ++count;
  }
  EXPECT_GT(count, 0) << text;
}

// One name a file in all that is said of it, whoever notices: its path, or stdin.
TEST_F(Messages, AFileHasOneName) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  write("other.obj", cube_obj());
  struct Row {
    std::string content, repair;
    int of_one, of_two;  // exit statuses
  };
  for (const Row& row : {Row{triangle + "v 5 5 5\nf 1 2 3\n", "none", 5, 0},
                         {triangle + "f 1 2 3\nf 3 1 2\n", "safe", 5, 0},
                         {triangle + "f 1 2 9\n", "none", 3, 8}}) {
    write("data/mesh.obj", row.content);
    for (const std::string name : {"data/mesh.obj", "-"}) {
      const std::string said = name == "-" ? "stdin" : name;
      run("fit " + name +
              " -o x.glb -f --input-format obj --max-iterations 1 --interpolation "
              "progressive --repair " +
              row.repair,
          row.of_one, {.input = row.content});
      expect_named(said_, said);
      run("fit " + name + " other.obj -o out/ -f --input-format obj", row.of_two,
          {.input = row.content});
      expect_named(said_, said);
    }
  }
}

// "1 vertex", whoever counts.
TEST_F(Messages, OneThingIsNotSeveral) {
  const std::regex wrong(
      "(^|[^0-9.,])1 (vertices|faces|edges|corners|points|triangles|quads|loops|"
      "boundary loops|components|iterations|jobs|tiles|bytes|lines)\\b");
  write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n");
  write("edge.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n");
  write("corner.obj", "v 0 0 0\nf 1\n");
  write("short.off", "OFF\n1 1 0\n0 0 0\n3 0\n");
  write("facet.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop\nendfacet\n");
  write("point.xyz", "0 0 0\n");
  write("two.xyz", "1\n0 0 0\n1 1 1\n");
  for (const char* line :
       {"fit one.obj -o a.glb -v --page a.html",
        "fit one.obj -o b.glb --levels 0 --cage b.obj --dry-run",
        "fit one.obj -o c.glb --interpolation fair -v",
        "fit one.obj -o d.glb --max-iterations 1 --tolerance 1e-15",
        "fit edge.obj -o e.glb --repair none", "fit corner.obj -o e.glb --repair none",
        "fit short.off -o f.glb", "fit facet.stl -o g.glb", "fit point.xyz -o h.glb --dry-run",
        "fit point.xyz -o h.glb", "fit two.xyz -o i.glb", "reconstruct point.xyz -o j.obj",
        "inspect one.obj", "verify one.obj one.obj"}) {
    const ProcessResult result = run_here(words_of(line));
    std::string said = result.out + result.err;
    if (exists("a.html")) said += read("a.html").substr(0, read("a.html").find("<script"));
    std::smatch found;
    EXPECT_FALSE(std::regex_search(said, found, wrong)) << line << ": " << found.str();
    std::filesystem::remove(path("a.html"));
  }
}

TEST(Faults, TheCodeIsTheLowestAndNothingIsSaidTwice) {
  using command::FaultList;
  using command::Faults;
  Faults faults;
  EXPECT_NO_THROW(faults.throw_if_any());
  faults.note([] { throw Error(ErrorCode::UnwritableOutput, "b exists"); });
  EXPECT_THROW(faults.throw_if_any(), Error);
  faults.note([] { throw Error(ErrorCode::UnreadableInput, "no a"); });
  faults.note([] { throw Error(ErrorCode::UnreadableInput, "no a"); });
  try {
    faults.throw_if_any();
    FAIL();
  } catch (const FaultList& list) {
    EXPECT_EQ(list.code(), ErrorCode::UnreadableInput);
    EXPECT_EQ(list.messages(), (std::vector<std::string>{"b exists", "no a"}));
  }
}

class Interrupt : public FolderTest {
 protected:
  // Sends the signal to a command that has seconds of work before it and is known to be at the
  // step.
  ProcessResult stop_by(int signal, const std::string& line, const std::string& step = "stencils") {
    write("torus.obj", torus_obj(150));
    PlanishProcess process(words_of(line + " --progress json"), {.folder = path("")});
    EXPECT_TRUE(process.wait_for_message("\"" + step + "\""));
    const auto signalled = std::chrono::steady_clock::now();
    ::kill(process.id(), signal);
    ProcessResult result = process.finish();
    took_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - signalled).count();
    return result;
  }

  const std::string fit_ = "fit torus.obj -o a.obj --cage c.obj --report r.json --levels 4";
  double took_ = 0;  ///< seconds from the signal to the end
};

TEST_F(Interrupt, EndsSoonWhereverTheWorkIsAndLeavesNothingBehind) {
  for (const char* step : {"read", "stencils", "solve", "measure", "write"}) {
    const ProcessResult result = stop_by(SIGINT, fit_, step);
    EXPECT_EQ(result.exit_code, 130) << step;
    EXPECT_THAT(result.err, HasSubstr("interrupted; no partial file is left"));
    // 0.2 s, and room for a machine that does other things as well.
    EXPECT_LT(took_, 1.0) << step;
    EXPECT_EQ(names(), std::vector<std::string>{"torus.obj"}) << step;
  }
  EXPECT_EQ(stop_by(SIGTERM, fit_).exit_code, 143);
  EXPECT_EQ(names(), std::vector<std::string>{"torus.obj"});
}

TEST_F(Interrupt, EndsARunOfSeveralJobs) {
  write("scene.json",
        R"({"version":1,"jobs":[)"
        R"({"name":"a","input":"torus.obj","outputs":[{"path":"a.obj","levels":[4]}]},)"
        R"({"name":"b","input":"torus.obj","outputs":[{"path":"b.obj","levels":[4]}]}]})");
  const ProcessResult result = stop_by(SIGINT, "run scene.json");
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_EQ(result.out, "");  // no table of jobs that failed
  EXPECT_THAT(result.err, HasSubstr("interrupted; no partial file is left"));
  EXPECT_EQ(names(), (std::vector<std::string>{"scene.json", "torus.obj"}));
}

TEST_F(Interrupt, TheSecondSignalKills) {
  write("torus.obj", torus_obj(150));
  int killed_by = 0;
  // The first may not yet be taken when the second comes, or the work may have ended.
  for (int attempt = 0; attempt < 60 && killed_by == 0; ++attempt) {
    PlanishProcess process(words_of(fit_ + " --progress json"), {.folder = path("")});
    EXPECT_TRUE(process.wait_for_message("\"stencils\""));
    ::kill(process.id(), SIGINT);
    std::this_thread::sleep_for(std::chrono::microseconds(20 * attempt));
    ::kill(process.id(), SIGINT);
    killed_by = process.finish().signal;
  }
  EXPECT_EQ(killed_by, SIGINT);
}

TEST(ExitCodes, FollowTheKindOfError) {
  using command::exit_code_of;
  using command::ExitCode;
  EXPECT_EQ(exit_code_of(ErrorCode::InvalidArgument), ExitCode::Usage);
  EXPECT_EQ(exit_code_of(ErrorCode::UnreadableInput), ExitCode::UnreadableInput);
  EXPECT_EQ(exit_code_of(ErrorCode::UnusableMesh), ExitCode::UnusableMesh);
  EXPECT_EQ(exit_code_of(ErrorCode::NoDevice), ExitCode::NoDevice);
  EXPECT_EQ(exit_code_of(ErrorCode::DeviceLost), ExitCode::NoDevice);
  EXPECT_EQ(exit_code_of(ErrorCode::OutOfMemory), ExitCode::NoDevice);
  EXPECT_EQ(exit_code_of(ErrorCode::UnwritableOutput), ExitCode::UnwritableOutput);
}

}  // namespace
}  // namespace planish::test
