#include <gmock/gmock.h>

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

TEST(Usage, HelpGoesToStdoutWithExamples) {
  const ProcessResult result = run_planish({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* command : {"fit", "run", "reconstruct", "verify", "inspect", "devices"}) {
    EXPECT_THAT(result.out, HasSubstr(std::string("\n  ") + command + " "));
  }
  EXPECT_THAT(result.out, HasSubstr("Examples:"));
  EXPECT_THAT(result.err, IsEmpty());
}

TEST(Usage, EveryCommandHasHelpWithExamples) {
  for (const char* command : {"fit", "run", "verify", "inspect", "devices"}) {
    const ProcessResult result = run_planish({command, "--help"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_THAT(result.out,
                AllOf(HasSubstr(std::string("Usage: planish ") + command), HasSubstr("Examples:")));
  }
}

TEST(Usage, VersionIsPrinted) {
  const ProcessResult result = run_planish({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, testing::MatchesRegex("planish [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Usage, NothingAtAllIsAnError) { expect_usage_error({}, "--help"); }

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
  expect_usage_error(with("--tolerance", "nan"), "--tolerance: nan is out of range");
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
  expect_usage_error({"fit", "a.obj"}, "nothing to write");
  expect_usage_error({"verify", "a.obj"}, "planish verify --help");
}

TEST(Usage, StdinNeedsAFormat) {
  expect_usage_error({"fit", "-", "-o", "b.glb"}, "--input-format");
  expect_usage_error({"fit", "-", "--input-format", "objj", "-o", "b.glb"}, "did you mean obj?");
}

}  // namespace
}  // namespace planish::test
