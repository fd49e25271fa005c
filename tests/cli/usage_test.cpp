#include <gmock/gmock.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "commands.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr std::array kCommands{"fit", "try", "run", "reconstruct", "verify", "inspect", "devices"};

using Usage = FolderTest;

TEST_F(Usage, HelpGoesToStdoutWithExamples) {
  for (const char* line : {"--help", "-h", "help"}) {
    const std::string text = run(line).out;
    for (const char* command : kCommands)
      EXPECT_THAT(text, HasSubstr(std::string("\n  ") + command + " "));
    EXPECT_THAT(text, HasSubstr("Examples:"));
    EXPECT_EQ(said_, "");
  }
  for (const std::string command : kCommands) {
    const std::string text = run(command + " --help").out;
    EXPECT_THAT(text, AllOf(HasSubstr("Usage: planish " + command), HasSubstr("Examples:")));
    EXPECT_EQ(run("help " + command).out, text);
  }
}

TEST_F(Usage, ShortHelpIsOneScreenOfEightyColumns) {
  for (const std::string command :
       {"fit", "try", "run", "verify", "inspect", "devices", "completion"}) {
    const auto lines = lines_of(run(command + " -h").out);
    EXPECT_LE(lines.size(), 40u) << command;
    EXPECT_GE(lines.size(), 5u) << command;
    for (const std::string& line : lines) EXPECT_LE(line.size(), 80u) << line;
  }
}

TEST_F(Usage, LongHelpHasEveryFlagByTopicInEightyColumns) {
  const std::string text = run("fit --help").out;
  for (const char* part : {"\nFiles:\n", "\nSurface:\n", "\nPoints", "\nMessages", "--polish",
                           "--min-angle", "Exit codes:"})
    EXPECT_THAT(text, HasSubstr(part));
  for (const std::string& line : lines_of(text)) EXPECT_LE(line.size(), 80u) << line;
}

TEST_F(Usage, VersionTellsCommitAndParts) {
  const std::string text = run("--version").out;
  EXPECT_THAT(text, testing::ContainsRegex("^planish [0-9]+\\.[0-9]+\\.[0-9]+ \\([0-9a-z]+\\)"));
  EXPECT_THAT(text, AllOf(HasSubstr("OpenSubdiv 3."), HasSubstr("Vulkan"), HasSubstr("CGAL")));
  EXPECT_EQ(run("version").out, text);
  EXPECT_EQ(run("-V").out, text);
}

TEST_F(Usage, NothingAtAllIsAnsweredWithTheCommandsAndOneExample) {
  EXPECT_EQ(run("", 2).out, "");
  for (const char* command : kCommands)
    EXPECT_THAT(said_, HasSubstr(std::string("\n  ") + command + " "));
  EXPECT_THAT(said_, HasSubstr("planish fit goblet.obj -o goblet.glb"));
}

// Completions in the shells themselves, and manuals as man reads them. What is not installed is
// skipped, unless PLANISH_REQUIRE_SHELLS is set.

using command::HelpOption;
using command::HelpPage;
using command::HelpTopic;

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
  std::string script(const std::string& shell) {
    return write("planish." + shell, run("completion " + shell).out);
  }
  std::vector<std::string> bash(const std::string& words, int place) {
    int status = 0;
    const std::string text = output_of_line(
        "bash --norc -c '. " + script("bash") + "; COMP_WORDS=(" + words +
            "); COMP_CWORD=" + std::to_string(place) + "; _planish; echo \"${COMPREPLY[@]}\"'",
        status);
    EXPECT_EQ(status, 0) << text;
    return words_of(text);
  }
};

// Words as bash splits them, and as it does where = is no break; files are bash's own.
TEST_F(Shells, BashCompletesCommandsFlagsAndWords) {
  struct Row {
    const char* words;
    int place;
    std::vector<std::string> completions;
  };
  for (const Row& row : std::vector<Row>{
           {"planish in", 1, {"inspect"}},
           {"planish fit --sol", 2, {"--solver"}},
           {"planish fit --solver c", 3, {"chebyshev", "cg"}},
           {"planish fit --cage c", 3, {}},
           {"planish verify --sol", 2, {}},
           {"planish fit --preset ", 3, {"paper"}},
           {"planish fit --solver = c", 4, {"chebyshev", "cg"}},
           {"planish fit --solver =", 3, {"chebyshev", "plain", "cg"}},
           {"planish fit --solver=c", 2, {"--solver=chebyshev", "--solver=cg"}},
           {"planish fit --cage = c", 4, {}},
           // The last of a list.
           {"planish fit --attributes c", 3, {"curvature"}},
           {"planish fit --attributes error,cur", 3, {"error,curvature"}},
           {"planish fit --attributes = error,fold,d", 4, {"error,fold,deviation"}},
           {"planish fit --attributes=error,d", 2, {"--attributes=error,deviation"}},
       })
    EXPECT_EQ(bash(row.words, row.place), row.completions) << row.words;
  EXPECT_THAT(bash("planish completion ", 2), Contains("fish"));
}

TEST_F(Shells, FishCompletesCommandsFlagsAndWords) {
  if (!has("fish")) GTEST_SKIP() << "fish is not installed";
  const auto fish = [&](const std::string& line) {
    int status = 0;
    return output_of_line("HOME=" + path("") + " fish --no-config -c 'source " + script("fish") +
                              "; complete -C \"" + line + "\"'",
                          status);
  };
  for (const auto& [line, completion] : std::vector<std::pair<const char*, const char*>>{
           {"planish in", "inspect\t"},
           {"planish fit --sol", "--solver\t"},
           {"planish fit --solver c", "chebyshev"},
           {"planish fit --preset ", "paper"},
           {"planish fit --solver=c", "--solver=chebyshev"},
           {"planish fit --attributes error,cur", "error,curvature"},
           {"planish fit --attributes=error,cur", "error,curvature"}})
    EXPECT_THAT(fish(line), HasSubstr(completion)) << line;
  EXPECT_THAT(fish("planish verify --sol"), Not(HasSubstr("--solver")));
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
  for (const auto& [line, completion] : std::vector<std::pair<const char*, const char*>>{
           {"planish insp", "inspect"},
           {"planish fit --solv", "--solver"},
           {"planish fit --solver cheb", "chebyshev"},
           {"planish fit --solver=cheb", "--solver=chebyshev"},
           {"planish fit --preset pa", "paper"},
           {"planish fit --attributes error,cur", "error,curvature"}})
    EXPECT_THAT(zsh(line, completion), HasSubstr("found")) << line;
  int status = 0;
  EXPECT_EQ(output_of_line("zsh -n " + script("zsh"), status), "");
  EXPECT_EQ(status, 0);
}

// Every flag of every command stands in all scripts: they come from the tree that parses.
TEST_F(Shells, AreToldEveryFlag) {
  const HelpPage help = command::all_help();
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const std::string text = run(std::string("completion ") + shell).out;
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
    const std::string file = write("page.1", run("manual " + page.name).out);
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
  const std::string text = run("manual fit").out;
  EXPECT_THAT(text, testing::StartsWith(".TH PLANISH-FIT 1"));
  EXPECT_EQ(run("manual fit").out, text);
}

}  // namespace
}  // namespace planish::test
