#include <gmock/gmock.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "commands.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

// A usage error: exit 2, a message with `part` on stderr, nothing on stdout.
void expect_usage_error(const std::vector<std::string>& arguments, const std::string& part) {
  const ProcessResult result = run_planish(arguments);
  EXPECT_EQ(result.exit_code, 2) << part;
  EXPECT_THAT(result.err, AllOf(StartsWith("planish: error: "), HasSubstr(part)));
  EXPECT_THAT(result.out, IsEmpty());
}

constexpr std::array kCommands{"fit", "run", "reconstruct", "verify", "inspect", "devices"};

TEST(Usage, HelpGoesToStdoutWithExamples) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--help"}, {"-h"}, {"help"}}) {
    const ProcessResult result = run_planish(arguments);
    EXPECT_EQ(result.exit_code, 0);
    for (const char* command : kCommands) {
      EXPECT_THAT(result.out, HasSubstr(std::string("\n  ") + command + " "));
    }
    EXPECT_THAT(result.out, HasSubstr("Examples:"));
    EXPECT_THAT(result.err, IsEmpty());
  }
}

TEST(Usage, EveryCommandHasHelpWithExamples) {
  for (const char* command : kCommands) {
    const ProcessResult result = run_planish({command, "--help"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_THAT(result.out,
                AllOf(HasSubstr(std::string("Usage: planish ") + command), HasSubstr("Examples:")));
    EXPECT_EQ(run_planish({"help", command}).out, result.out);
  }
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Usage, ShortHelpIsOneScreenOfEightyColumns) {
  for (const char* command : {"fit", "run", "verify", "inspect", "devices", "completion"}) {
    const auto lines = lines_of(run_planish({command, "-h"}).out);
    EXPECT_LE(lines.size(), 40u) << command;
    EXPECT_GE(lines.size(), 5u) << command;
    for (const std::string& line : lines) EXPECT_LE(line.size(), 80u) << line;
  }
  EXPECT_LE(lines_of(run_planish({"fit", "-h"}).out).size(), 40u);
}

TEST(Usage, LongHelpHasEveryFlagByTopicInEightyColumns) {
  const std::string text = run_planish({"fit", "--help"}).out;
  for (const char* part : {"\nFiles:\n", "\nSurface:\n", "\nPoints", "\nMessages", "--polish",
                           "--min-angle", "Exit codes:"})
    EXPECT_THAT(text, HasSubstr(part));
  for (const std::string& line : lines_of(text)) EXPECT_LE(line.size(), 80u) << line;
}

TEST(Usage, VersionTellsCommitAndParts) {
  const ProcessResult result = run_planish({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out,
              testing::ContainsRegex("^planish [0-9]+\\.[0-9]+\\.[0-9]+ \\([0-9a-z]+\\)"));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("OpenSubdiv 3."), HasSubstr("Vulkan"), HasSubstr("CGAL")));
  for (const char* reflex : {"version", "-V"})
    EXPECT_EQ(run_planish({reflex}).out, result.out) << reflex;
}

TEST(Usage, NothingAtAllIsAnsweredWithTheCommandsAndOneExample) {
  const ProcessResult result = run_planish({});
  EXPECT_EQ(result.exit_code, 2);
  for (const char* command : kCommands)
    EXPECT_THAT(result.err, HasSubstr(std::string("\n  ") + command + " "));
  EXPECT_THAT(result.err, HasSubstr("planish fit goblet.obj -o goblet.glb"));
  EXPECT_THAT(result.out, IsEmpty());
}

TEST(Usage, AFileInThePlaceOfACommandIsAnsweredWithTheLineToType) {
  expect_usage_error({"dir/goblet.obj"}, "did you mean: planish fit dir/goblet.obj -o goblet.glb");
  expect_usage_error({"table.json"}, "did you mean: planish run table.json");
  expect_usage_error({"run", "a.obj"}, "did you mean: planish fit a.obj -o a.glb");
}

TEST(Usage, WhatAnUnsetVariableLeavesEmptyIsRefused) {
  expect_usage_error({"fit", ""}, "an argument is empty; is a variable not set?");
  expect_usage_error({"fit", "a.obj", "-o", "a.glb", "--report", ""},
                     "--report: what follows is empty; is a variable not set?");
  for (const char* command : {"reconstruct", "inspect", "run"})
    expect_usage_error({command, ""}, "an argument is empty");
  expect_usage_error({"query", "a.obj", "--points", ""}, "--points: what follows is empty");
}

// It would be refused: the input is not written over.
TEST(Usage, TheInputIsNotProposedAsOutput) {
  expect_usage_error({"fit", "a.glb"}, "did you mean: planish fit a.glb -o a_surface.glb");
  expect_usage_error({"dir/a.glb"}, "did you mean: planish fit dir/a.glb -o a.glb");
}

TEST(Usage, AnArgumentMayBeCalledAsACommandIs) {
  const ProcessResult result = run_planish({"inspect", "fit"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("fit: cannot read: No such file"));
}

TEST(Usage, AFlagCutShortIsCompleted) {
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "--tol", "1"}, "did you mean --tolerance?");
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "-x"}, "-x is no flag of planish fit");
}

TEST(Usage, NumbersThatAreNoneSayWhatIsWanted) {
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "--tolerance", "abc"},
                     "--tolerance: \"abc\" is no number; a fraction of the bounding-box diagonal");
  expect_usage_error(
      {"fit", "a.obj", "-o", "b.glb", "--creases", "40"},
      "--creases: \"40\" is not one of choose, use, ignore, normals, auto:DEGREES; did you mean "
      "auto:40?");
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "--creases", "ignroe"},
                     "did you mean ignore?");
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "-j", "0"}, "--jobs: 0 is out of range");
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "--color", "sometimes"},
                     "--color: \"sometimes\" is not one of auto, always, never");
}

TEST(Usage, ReportsEndInJson) {
  expect_usage_error({"fit", "a.obj", "--report", "r.html"},
                     "--report: r.html: a report is JSON, and its name ends in .json");
}

TEST(Usage, ASlipInACommandNamesTheNearest) {
  expect_usage_error({"fti", "a.obj"}, "\"fti\" is no command; did you mean fit?");
}

TEST(Usage, ASlipInAFlagNamesTheNearest) {
  expect_usage_error({"fit", "--wieghts", "averaged", "a.obj", "-o", "b.glb"},
                     "--wieghts is no flag of planish fit; did you mean --weights?");
  expect_usage_error({"verify", "a.obj", "b.obj", "--tolerence=1"}, "did you mean --tolerance?");
}

TEST(Usage, ASlipInAValueNamesTheNearest) {
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "--solver", "chebishev"},
                     "--solver: \"chebishev\" is not one of chebyshev, plain, cg; did you mean "
                     "chebyshev?");
}

TEST(Usage, NumbersOutOfRangeAreRefused) {
  const std::vector<std::string> fit{"fit", "a.obj", "-o", "b.glb"};
  const auto with = [&](const char* flag, const char* value) {
    std::vector<std::string> arguments = fit;
    arguments.insert(arguments.end(), {flag, value});
    return arguments;
  };
  expect_usage_error(with("--tolerance", "0"), "--tolerance: 0 is out of range");
  expect_usage_error(with("--tolerance", "nan"), "--tolerance: \"nan\" is no number");
  expect_usage_error(with("--tolerance", "1,5"), "--tolerance");
  expect_usage_error(with("--max-iterations", "-1"), "--max-iterations: -1 is out of range");
  expect_usage_error(with("--max-iterations", "many"), "--max-iterations");
  expect_usage_error(with("--creases", "auto:181"), "--creases: \"181\" is no angle of 0 to 180");
  expect_usage_error(with("--creases", "auto:"), "--creases: \"\" is no angle");
  expect_usage_error(with("--repair", "saef"), "--repair: \"saef\" is not one of safe, none");
  expect_usage_error(with("--interpolation", "fare"),
                     "--interpolation: \"fare\" is not one of auto, progressive, fair; did you "
                     "mean fair?");
  expect_usage_error(with("--polish", "-1"), "--polish: -1 is out of range");
  expect_usage_error(with("--polish", "1001"), "--polish: 1001 is out of range");
  expect_usage_error(with("--levels", "7"), "--levels: 7 is out of range; levels are 0 to 6");
  expect_usage_error(with("--levels", "2,2"), "--levels: level 2 is named twice");
  expect_usage_error(with("--levels", "2;3"), "--levels: \"2;3\" is no list of levels");
  expect_usage_error(with("--levels", "2,"), "is no list of levels");
}

TEST(Usage, OtherSchemesHaveNeitherWeightsNorTheFairMethod) {
  for (const std::string scheme : {"catmull-clark", "loop"}) {
    const auto with = [&](std::vector<std::string> flags) {
      flags.insert(flags.begin(), {"fit", "a.obj", "-o", "b.glb", "--scheme", scheme});
      return flags;
    };
    expect_usage_error(
        with({"--interpolation", "fair"}),
        "--interpolation: fair builds control points of Doo-Sabin's level 1, which " + scheme +
            " does not have; take progressive, or --scheme doo-sabin");
    expect_usage_error(with({"--weights", "averaged"}),
                       "--weights: averaged belongs to --scheme doo-sabin");
    expect_usage_error(with({"--preset", "paper"}),
                       "--weights: averaged belongs to --scheme doo-sabin; leave it and --preset "
                       "paper out with --scheme " +
                           scheme);
  }
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "--scheme", "lop"},
                     "--scheme: \"lop\" is not one of doo-sabin, catmull-clark, loop; did you mean "
                     "loop?");
}

TEST(Usage, PrecisionIsForTheCpu) {
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "--device", "vulkan", "--precision", "double"},
                     "--precision");
}

TEST(Usage, QuietAndVerboseContradict) {
  expect_usage_error({"fit", "a.obj", "-o", "b.glb", "-q", "-v"}, "contradict");
}

TEST(Usage, MissingArgumentsPointToTheHelp) {
  expect_usage_error({"fit"}, "planish fit --help");
  expect_usage_error({"fit", "a.obj"},
                     "nothing to write; did you mean: planish fit a.obj -o a.glb");
  expect_usage_error({"fit", "a.obj", "b.glb"}, "b.glb: no such input; did you mean -o b.glb?");
  expect_usage_error({"fit", "--", "a.obj", "-o", "b.glb"},
                     "-o stands after --, where flags end; put flags before it");
  expect_usage_error({"verify", "a.obj"}, "planish verify --help");
}

TEST(Usage, TheFormatOfStdinIsAWordThatIsKnown) {
  expect_usage_error({"fit", "-", "--input-format", "objj", "-o", "b.glb"}, "did you mean obj?");
}

// Completions in the shells themselves, and manuals as man reads them. What is not installed is
// skipped, unless PLANISH_REQUIRE_SHELLS is set.

using command::HelpOption;
using command::HelpPage;
using command::HelpTopic;
using testing::Contains;
using testing::Not;

// What a line of shell prints, on both streams.
std::string output_of_line(const std::string& line, int& status) {
  FILE* pipe = ::popen((line + " 2>&1").c_str(), "r");
  std::string text;
  std::array<char, 4096> buffer{};
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    text.append(buffer.data(), count);
  const int ended = ::pclose(pipe);
  status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
  return text;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

class Shells : public FolderTest {
 protected:
  // False, having said why, where the program is not there.
  static bool has(const std::string& program) {
    int status = 0;
    (void)output_of_line("command -v " + program, status);
    if (status == 0) return true;
    if (std::getenv("PLANISH_REQUIRE_SHELLS") != nullptr)
      ADD_FAILURE() << program << " is not installed, and PLANISH_REQUIRE_SHELLS is set";
    return false;
  }
  std::string script(const std::string& shell) const {
    return write("planish." + shell, run_planish({"completion", shell}).out);
  }
  std::vector<std::string> bash(const std::string& words, int place) const {
    int status = 0;
    const std::string text = output_of_line(
        "bash --norc -c '. " + script("bash") + "; COMP_WORDS=(" + words +
            "); COMP_CWORD=" + std::to_string(place) + "; _planish; echo \"${COMPREPLY[@]}\"'",
        status);
    EXPECT_EQ(status, 0) << text;
    return words_of(text);
  }
};

TEST_F(Shells, BashCompletesCommandsFlagsAndWords) {
  EXPECT_THAT(bash("planish in", 1), testing::ElementsAre("inspect"));
  EXPECT_THAT(bash("planish fit --sol", 2), testing::ElementsAre("--solver"));
  EXPECT_THAT(bash("planish fit --solver c", 3), testing::ElementsAre("chebyshev", "cg"));
  EXPECT_THAT(bash("planish fit --cage c", 3), IsEmpty());  // files are bash's own
  EXPECT_THAT(bash("planish verify --sol", 2), IsEmpty());
  EXPECT_THAT(bash("planish completion ", 2), Contains("fish"));
  EXPECT_THAT(bash("planish fit --preset ", 3), testing::ElementsAre("paper"));
}

// As bash splits it, and as it does where = is no break.
TEST_F(Shells, BashCompletesValuesBehindAnEqualsSign) {
  EXPECT_THAT(bash("planish fit --solver = c", 4), testing::ElementsAre("chebyshev", "cg"));
  EXPECT_THAT(bash("planish fit --solver =", 3), testing::ElementsAre("chebyshev", "plain", "cg"));
  EXPECT_THAT(bash("planish fit --solver=c", 2),
              testing::ElementsAre("--solver=chebyshev", "--solver=cg"));
  EXPECT_THAT(bash("planish fit --cage = c", 4), IsEmpty());
}

TEST_F(Shells, BashCompletesTheLastOfAList) {
  EXPECT_THAT(bash("planish fit --attributes c", 3), testing::ElementsAre("curvature"));
  EXPECT_THAT(bash("planish fit --attributes error,cur", 3),
              testing::ElementsAre("error,curvature"));
  EXPECT_THAT(bash("planish fit --attributes = error,fold,d", 4),
              testing::ElementsAre("error,fold,deviation"));
  EXPECT_THAT(bash("planish fit --attributes=error,d", 2),
              testing::ElementsAre("--attributes=error,deviation"));
}

TEST_F(Shells, FishCompletesCommandsFlagsAndWords) {
  if (!has("fish")) GTEST_SKIP() << "fish is not installed";
  const auto fish = [&](const std::string& line) {
    int status = 0;
    return output_of_line("HOME=" + path("") + " fish --no-config -c 'source " + script("fish") +
                              "; complete -C \"" + line + "\"'",
                          status);
  };
  EXPECT_THAT(fish("planish in"), HasSubstr("inspect\t"));
  EXPECT_THAT(fish("planish fit --sol"), HasSubstr("--solver\t"));
  EXPECT_THAT(fish("planish fit --solver c"), HasSubstr("chebyshev"));
  EXPECT_THAT(fish("planish verify --sol"), Not(HasSubstr("--solver")));
  EXPECT_THAT(fish("planish fit --preset "), HasSubstr("paper"));
  EXPECT_THAT(fish("planish fit --solver=c"), HasSubstr("--solver=chebyshev"));
  EXPECT_THAT(fish("planish fit --attributes error,cur"), HasSubstr("error,curvature"));
  EXPECT_THAT(fish("planish fit --attributes=error,cur"), HasSubstr("error,curvature"));
}

TEST_F(Shells, ZshCompletesCommandsFlagsAndWords) {
  if (!has("zsh")) GTEST_SKIP() << "zsh is not installed";
  write("try.zsh",
        "zmodload zsh/zpty\n"
        "zpty z zsh -f -i\n"
        "zpty -w z 'PS1=; autoload -U compinit; compinit -u -D; . '$1'; echo rea''dy'\n"
        "zpty -r -m z text '*ready*'\n"
        "zpty -n -w z $2$'\\t'\n"
        "zpty -r -m z text \"*$3*\" && print -r -- found\n");
  const auto zsh = [&](const std::string& line, const std::string& wanted) {
    int status = 0;
    return output_of_line("timeout 60 zsh -f " + path("try.zsh") + " " + script("zsh") + " '" +
                              line + "' '" + wanted + "'",
                          status);
  };
  EXPECT_THAT(zsh("planish insp", "inspect"), HasSubstr("found"));
  EXPECT_THAT(zsh("planish fit --solv", "--solver"), HasSubstr("found"));
  EXPECT_THAT(zsh("planish fit --solver cheb", "chebyshev"), HasSubstr("found"));
  EXPECT_THAT(zsh("planish fit --solver=cheb", "--solver=chebyshev"), HasSubstr("found"));
  EXPECT_THAT(zsh("planish fit --preset pa", "paper"), HasSubstr("found"));
  EXPECT_THAT(zsh("planish fit --attributes error,cur", "error,curvature"), HasSubstr("found"));
  int status = 0;
  EXPECT_EQ(output_of_line("zsh -n " + script("zsh"), status), "");
  EXPECT_EQ(status, 0);
}

TEST(Completion, AnUnknownShellIsAnError) {
  const ProcessResult result = run_planish({"completion", "bsh"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("did you mean bash?"));
}

// Every flag of every command stands in all scripts: they come from the tree that parses.
TEST(Completion, HasEveryFlag) {
  const HelpPage help = command::all_help();
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const std::string text = run_planish({"completion", shell}).out;
    for (const HelpPage& page : help.commands) {
      EXPECT_THAT(text, HasSubstr(page.name));
      for (const HelpTopic& topic : page.topics)
        for (const HelpOption& option : topic.options)
          for (const std::string& name : option.names)
            EXPECT_THAT(text, HasSubstr(shell == std::string("fish")
                                            ? name.substr(name.starts_with("--") ? 2 : 1)
                                            : name));
    }
  }
}

TEST_F(Shells, ManReadsEveryManualWithoutAWarning) {
  if (!has("man")) GTEST_SKIP() << "man is not installed";
  const HelpPage help = command::all_help();
  std::vector<HelpPage> pages = help.commands;
  pages.push_back(help);
  for (const HelpPage& page : pages) {
    std::vector<std::string> arguments{"manual"};
    if (!page.name.empty()) arguments.push_back(page.name);
    const std::string file = write("page.1", run_planish(arguments).out);
    int status = 0;
    const std::string warnings = output_of_line(
        "LC_ALL=C.UTF-8 man --warnings -E UTF-8 -l -Tutf8 -Z " + file + " >/dev/null", status);
    EXPECT_EQ(warnings, "") << page.name;
    const std::string shown = output_of_line(
        "LC_ALL=C.UTF-8 MANWIDTH=80 MAN_KEEP_FORMATTING= man -l " + file + " | col -b", status);
    for (const HelpTopic& topic : page.topics)
      for (const HelpOption& option : topic.options)
        EXPECT_THAT(shown, HasSubstr(option.names.back())) << page.name;
    EXPECT_THAT(shown, HasSubstr(page.full_name() + " "));
  }
}

// Those that are installed.
TEST_F(Shells, EveryCommandHasAManual) {
  for (const HelpPage& page : command::all_help().commands) {
    const std::filesystem::path file =
        std::filesystem::path(PLANISH_HELP_FOLDER) / ("planish-" + page.name + ".1");
    EXPECT_TRUE(std::filesystem::exists(file)) << file;
  }
}

TEST_F(Shells, AManualIsTheSameFromRunToRun) {
  EXPECT_EQ(run_planish({"manual", "fit"}).out, run_planish({"manual", "fit"}).out);
  EXPECT_THAT(run_planish({"manual", "fit"}).out, testing::StartsWith(".TH PLANISH-FIT 1"));
}

}  // namespace
}  // namespace planish::test
