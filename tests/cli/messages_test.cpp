// What reaches a terminal, a pipe and another program.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "terminal/faults.h"

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
