// Completions in the shells themselves, and manuals as man reads them. What is not installed is
// skipped, unless PLANISH_REQUIRE_SHELLS is set.
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

using command::HelpOption;
using command::HelpPage;
using command::HelpTopic;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
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
