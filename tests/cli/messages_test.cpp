// What reaches a terminal, a pipe and another program.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <regex>
#include <sstream>
#include <utility>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "terminal.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// No byte that a terminal obeys, but line ends.
bool is_plain(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte < 0x20 && byte != '\n') || byte == 0x7F) return false;
  }
  return text.find("\xE2\x80\xAE") == std::string::npos &&
         text.find("\xE2\x80\x8B") == std::string::npos;
}

std::ptrdiff_t line_count(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n');
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
  PlanishProcess::Options here(bool terminal = false) const {
    return {.input = {}, .terminal = terminal, .environment = {"TERM=xterm"}, .folder = path("")};
  }
};

TEST_F(Messages, HostileNamesOfFilesAreShownNotObeyed) {
  write("good.obj", cube_obj());
  for (const std::string& name : kHostile) {
    const std::string file = name + ".obj";
    const auto quiet = run_planish({"fit", "-q", "good.obj", "none.obj", "-o", "good.glb"}, here());
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
      const ProcessResult result = run_planish(arguments, here());
      EXPECT_NE(result.exit_code, 0);
      EXPECT_TRUE(is_plain(result.err)) << result.err;
      EXPECT_THAT(result.out, IsEmpty());
    }
    // No line is broken by the name: the friendly name gives as many.
    const auto lines = [&](const std::string& input) {
      return line_count(run_planish({"fit", input, "-o", "x.glb"}, here()).err);
    };
    EXPECT_EQ(lines(file), lines("friendly.obj")) << name;
  }
}

TEST_F(Messages, HostileNamesThatWorkAreShownInSummaries) {
  const std::string name = "a\x1b[31m\nb.obj";
  write(name, cube_obj());
  const ProcessResult fit = run_planish({"fit", name, "-o", "o\x1b[2J.glb", "--dry-run"}, here());
  EXPECT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_TRUE(is_plain(fit.out)) << fit.out;
  EXPECT_THAT(fit.out, HasSubstr("a\\x1b[31m\\nb.obj"));
  const ProcessResult done = run_planish({"fit", name, "-o", "o\x1b[2J.glb"}, here());
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_TRUE(is_plain(done.err)) << done.err;
  EXPECT_TRUE(is_plain(run_planish({"inspect", name}, here()).out));
}

TEST_F(Messages, NamesOfASceneAreShownNotObeyed) {
  write("cube.obj", cube_obj());
  write("s.json", R"({"version":1,"jobs":[{"name":"\u001b[31mred\nline\u202e","input":"cube.obj",)"
                  R"("outputs":[{"path":"x.glb"}]},{"name":"\u001b[0m","input":"none.obj"}]})");
  const ProcessResult result = run_planish({"run", "s.json"}, here());
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_TRUE(is_plain(result.out)) << result.out;
  EXPECT_TRUE(is_plain(result.err)) << result.err;
  EXPECT_THAT(result.out, HasSubstr("\\x1b[31mred\\nline\\u202e"));
}

TEST_F(Messages, ErrorsObeyColor) {
  const std::vector<std::string> wrong{"fit", "none.obj", "-o", "x.glb", "--color"};
  const auto with = [&](const char* color, bool terminal) {
    std::vector<std::string> arguments = wrong;
    arguments.emplace_back(color);
    const ProcessResult result = run_planish(arguments, here(terminal));
    return result.out + result.err;
  };
  EXPECT_THAT(with("always", false), HasSubstr("\033[1;31merror"));
  EXPECT_THAT(with("never", true), Not(HasSubstr("\033")));
  EXPECT_THAT(with("auto", true), HasSubstr("\033[1;31merror"));
  EXPECT_THAT(with("auto", false), Not(HasSubstr("\033")));
  // What is set to nothing is not set (no-color.org).
  for (const auto& [setting, is_colored] : {std::pair{"NO_COLOR=", true}, {"NO_COLOR=1", false}}) {
    std::vector<std::string> arguments = wrong;
    arguments.emplace_back("auto");
    PlanishProcess::Options options = here(true);
    options.environment.emplace_back(setting);
    const ProcessResult result = run_planish(arguments, options);
    EXPECT_EQ((result.out + result.err).find("\033[1;31merror") != std::string::npos, is_colored)
        << setting;
  }
  const ProcessResult early = run_planish({"fti", "--color=always"}, here());
  EXPECT_THAT(early.err, HasSubstr("\033[1;31merror"));
}

TEST_F(Messages, BytesDoNotGoToATerminal) {
  write("cube.obj", cube_obj());
  const ProcessResult result = run_planish({"fit", "cube.obj", "-o", "-"}, here(true));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.out, AllOf(HasSubstr("not written to a terminal"), Not(HasSubstr("glTF"))));
  const ProcessResult report = run_planish({"fit", "cube.obj", "--report", "-", "-q"}, here(true));
  EXPECT_EQ(report.exit_code, 0);
  EXPECT_THAT(report.out, HasSubstr("planish.report/1"));
}

TEST_F(Messages, AReaderThatLeavesEndsTheCommandSilently) {
  write("cube.obj", cube_obj());
  PlanishProcess::Options options = here();
  options.closed_stdout = true;
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"fit", "cube.obj", "-o", "-", "-q"}, {"--help"}, {"devices"}}) {
    const ProcessResult result = run_planish(arguments, options);
    EXPECT_EQ(result.signal, SIGPIPE) << arguments.front();
    EXPECT_THAT(result.err, IsEmpty());
  }
  EXPECT_EQ(names(), std::vector<std::string>{"cube.obj"});
}

TEST_F(Messages, AllThatIsWrongIsSaidAtOnceTheInputFirst) {
  write("old.glb", "precious");
  const ProcessResult result = run_planish(
      {"fit", "GOBLET.OBJ", "-o", "old.glb", "--cage", "missing/c.obj", "--report", "r.html"},
      here());
  const std::size_t input = result.err.find("GOBLET.OBJ: cannot read: No such file");
  const std::size_t output = result.err.find("old.glb exists; --force overwrites it");
  ASSERT_NE(input, std::string::npos) << result.err;
  ASSERT_NE(output, std::string::npos) << result.err;
  EXPECT_LT(input, output);
  EXPECT_THAT(result.err, AllOf(HasSubstr("no folder"), HasSubstr("ends in .json")));
  EXPECT_EQ(line_count(result.err), 4);
  EXPECT_EQ(result.exit_code, 2);  // the lowest of theirs
}

TEST_F(Messages, WithJsonProgressEveryLineIsAnObject) {
  write("cube.obj", cube_obj());
  write("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n");  // gives a warning
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"fit", "two.obj", "-o", "x.glb", "--progress", "json"},
        {"fit", "none.obj", "-o", "y.glb", "--progress=json"},
        {"fit", "cube.obj", "two.obj", "-o", "out/", "--progress", "json"}}) {
    const ProcessResult result = run_planish(arguments, here());
    std::istringstream lines(result.err);
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count)
      EXPECT_TRUE(nlohmann::json::parse(line, nullptr, false).is_object()) << line;
    EXPECT_GT(count, 0);
  }
}

// The name that begins a message, and stands in it once.
void expect_named(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line);) {
    const bool is_message =
        line.starts_with("planish: warning: ") || line.starts_with("planish: error: ");
    if (!is_message || line.ends_with("jobs failed")) continue;
    const std::string said = line.substr(line.find(": ", line.find(": ") + 2) + 2);
    EXPECT_THAT(said, StartsWith(name + ":")) << text;
    EXPECT_EQ(said.find(name, 1), std::string::npos) << text;
    EXPECT_THAT(said, Not(HasSubstr("-: "))) << text;
    ++count;
  }
  EXPECT_GT(count, 0) << text;
}

// One name a file in all that is said of it, whoever notices: its path, or stdin.
TEST_F(Messages, AFileHasOneName) {
  const std::string unused = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n";
  const std::string twice = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 1 2\n";
  const std::string broken = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
  std::filesystem::create_directory(path("data"));
  write("other.obj", cube_obj());
  for (const std::string& content : {unused, twice, broken}) {
    write("data/mesh.obj", content);
    for (const std::string& name : {std::string("data/mesh.obj"), std::string("-")}) {
      PlanishProcess::Options options = here();
      options.input = content;
      std::vector<std::string> one{"fit",
                                   name,
                                   "-o",
                                   "x.glb",
                                   "-f",
                                   "--input-format",
                                   "obj",
                                   "--max-iterations",
                                   "1",
                                   "--interpolation",
                                   "progressive",
                                   "--repair",
                                   content == twice ? "safe" : "none"};
      const std::string said = name == "-" ? "stdin" : name;
      expect_named(run_planish(one, options).err, said);
      one = {"fit", name, "other.obj", "-o", "out/", "-f", "--input-format", "obj"};
      expect_named(run_planish(one, options).err, said);
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
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"fit", "one.obj", "-o", "a.glb", "-v", "--page", "a.html"},
        {"fit", "one.obj", "-o", "b.glb", "--levels", "0", "--cage", "b.obj", "--dry-run"},
        {"fit", "one.obj", "-o", "c.glb", "--interpolation", "fair", "-v"},
        {"fit", "one.obj", "-o", "d.glb", "--max-iterations", "1", "--tolerance", "1e-15"},
        {"fit", "edge.obj", "-o", "e.glb", "--repair", "none"},
        {"fit", "corner.obj", "-o", "e.glb", "--repair", "none"},
        {"fit", "short.off", "-o", "f.glb"},
        {"fit", "facet.stl", "-o", "g.glb"},
        {"fit", "point.xyz", "-o", "h.glb", "--dry-run"},
        {"fit", "point.xyz", "-o", "h.glb"},
        {"fit", "two.xyz", "-o", "i.glb"},
        {"reconstruct", "point.xyz", "-o", "j.obj"},
        {"inspect", "one.obj"},
        {"verify", "one.obj", "one.obj"}}) {
    const ProcessResult result = run_planish(arguments, here());
    std::string said = result.out + result.err;
    if (exists("a.html")) said += read("a.html").substr(0, read("a.html").find("<script"));
    std::smatch found;
    EXPECT_FALSE(std::regex_search(said, found, wrong)) << arguments[1] << ": " << found.str();
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

}  // namespace
}  // namespace planish::test
