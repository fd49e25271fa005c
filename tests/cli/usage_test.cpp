#include <gmock/gmock.h>

#include <array>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"

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

}  // namespace
}  // namespace planish::test
