// Every option of `planish fit` and `planish run` either works in planish-mpi or is refused by name
// with a remedy: the list is planish's own, so that no new one is forgotten.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "commands.h"
#include "mpi_job.h"
#include "planish/core/json.h"
#include "scene_file.h"

namespace planish::test {
namespace {

using command::HelpOption;
using command::MpiOption;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string kNo = " is not available in planish-mpi: ";
const std::string kNoRemedy = "take planish on one machine";

std::string refusal_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "planish-mpi");
  try {
    const command::MpiRequest request = command::parse_mpi_flags(arguments);
    for (const Job& job : request.jobs) (void)command::mpi_job_of(job, request.own);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

std::string long_name(const HelpOption& option) {
  const auto found = std::ranges::find_if(
      option.names, [](const std::string& name) { return name.starts_with("--"); });
  return found == option.names.end() ? std::string() : *found;
}

std::string setting_of(const std::string& flag) {
  std::string name = flag.substr(2);
  std::ranges::replace(name, '-', '_');
  return name;
}

// A value that planish takes, and what has to stand beside the flag.
std::vector<std::string> with_flag(const HelpOption& option, const std::string& word) {
  static const std::map<std::string, std::vector<std::string>> known{
      {"--output", {"x.json"}},
      {"--cage", {"c.ply"}},
      {"--report", {"r.json"}},
      {"--tolerance", {"1e-4"}},
      {"--polish", {"3", "--interpolation", "fair"}},
      {"--bake", {"64"}},
      {"--tile-vertices", {"1024"}},
      {"--chord-error", {"0.01"}},
      {"--angle", {"10"}},
      {"--weld", {"0.01"}},
      {"--page-limit", {"8M"}},
      {"--creases", {"use"}},
      {"--attributes", {"error,fold"}},
      {"--device", {"cpu"}},
      {"--preset", {"paper"}}};
  const std::string flag = long_name(option);
  if (option.value.empty()) return {flag};
  const auto found = known.find(flag);
  std::vector<std::string> words =
      found == known.end() ? std::vector<std::string>{"2"} : found->second;
  if (!word.empty()) words.front() = word;
  words.insert(words.begin(), flag);
  return words;
}

struct Walked {
  int taken = 0, some = 0, refused = 0;
};

void expect_answer(const std::string& command, const HelpOption& option, Walked& walked) {
  const std::string flag = long_name(option);
  if (flag.empty() || flag == "--help") return;
  const auto ask = [&](const std::string& word) {
    std::vector<std::string> arguments{command, "mesh.obj"};
    if (command == "fit" && flag != "--output") arguments.insert(arguments.end(), {"-o", "t.json"});
    const auto more = with_flag(option, word);
    arguments.insert(arguments.end(), more.begin(), more.end());
    return refusal_of(arguments);
  };
  // The report of all jobs is refused, that of one is not.
  const bool is_of_all = command == "run" && flag == "--report";
  const MpiOption answer = is_of_all ? MpiOption::Refused : command::mpi_option(setting_of(flag));
  std::vector<std::string> words = option.choices;
  std::erase_if(words, [](const std::string& word) { return word.find(':') != std::string::npos; });
  if (words.empty() || flag == "--device") words = {""};
  std::size_t working = 0;
  for (const std::string& word : words) {
    const std::string message = ask(word);
    if (message.empty()) {
      ++working;
      continue;
    }
    EXPECT_THAT(message, StartsWith(flag + ": ")) << word;
    EXPECT_THAT(message, HasSubstr(kNo)) << word;
    EXPECT_THAT(message, Not(HasSubstr(kNo + kNoRemedy))) << "no remedy for " << flag;
  }
  if (answer == MpiOption::Taken) {
    EXPECT_EQ(working, words.size()) << flag;
    ++walked.taken;
  } else if (answer == MpiOption::SomeWords) {
    EXPECT_GT(working, 0u) << flag;
    ++walked.some;
  } else {
    EXPECT_EQ(working, 0u) << flag;
    ++walked.refused;
  }
}

TEST(MpiOptions, EveryFlagOfFitAndRunWorksOrIsRefusedWithARemedy) {
  std::map<std::string, Walked> walked;
  for (const command::HelpPage& page : command::all_help().commands) {
    if (page.name != "fit" && page.name != "run") continue;
    for (const command::HelpTopic& topic : page.topics)
      for (const HelpOption& option : topic.options)
        expect_answer(page.name, option, walked[page.name]);
  }
  EXPECT_GE(walked["fit"].taken, 18);
  EXPECT_GE(walked["fit"].some, 7);
  EXPECT_GE(walked["fit"].refused, 15);
  EXPECT_GE(walked["run"].taken, 3);
  EXPECT_GE(walked["run"].refused, 5);
}

TEST(MpiOptions, EveryKeyOfASceneIsKnown) {
  using command::SceneObject;
  int refused = 0;
  for (const std::string_view key : command::scene_keys(SceneObject::Defaults)) {
    if (key == "solve" || command::mpi_option(key) != MpiOption::Refused) continue;
    ++refused;
    const GivenSetting given{std::string(key), "scene.json:1: jobs[0]", "x"};
    try {
      command::require_available({&given, 1}, {.adaptive = {.angle = 1}});
      ADD_FAILURE() << key << " is taken";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), StartsWith("scene.json:1: jobs[0]: x" + kNo));
      EXPECT_THAT(error.what(), Not(HasSubstr(kNo + kNoRemedy))) << key;
    }
  }
  EXPECT_GE(refused, 5);
}

// Of the scene's only job.
std::string scene_refusal(const json& settings, const std::string& output = "t.json",
                          const char* what = "surface") {
  json job{{"input", "m.obj"}, {"outputs", {{{"path", "ok.ply"}, {"what", "cage"}}}}};
  job["outputs"].push_back({{"path", output}, {"what", what}});
  job.update(settings);
  const std::string text = json{{"version", 1}, {"jobs", {job}}}.dump();
  try {
    (void)command::mpi_job_of(command::parse_scene(text, "s.json", "").at(0), {});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    return error.what();
  }
  return {};
}

TEST(MpiOptions, ScenesAreRefusedByPlaceValueAndRemedy) {
  const auto expect = [&](const json& settings, const std::string& begin) {
    const std::string message = scene_refusal(settings);
    EXPECT_THAT(message, StartsWith("s.json:1: jobs[0]." + begin));
  };
  EXPECT_EQ(scene_refusal(json::object()), "");
  expect({{"solve", {{"solver", "cg"}}}}, "solve.solver: cg" + kNo + "take chebyshev or plain");
  expect({{"scheme", "loop"}}, "scheme: loop" + kNo + "take doo-sabin");
  expect({{"repair", "safe"}}, "repair: safe" + kNo + "nothing is mended");
  expect({{"weld", 0.001}}, "weld: 0.001" + kNo + "nothing is welded");
  expect({{"precision", "float"}}, "precision: float" + kNo);
  expect({{"device", "vulkan"}}, "device: vulkan" + kNo + "ranks work on the CPU");
  expect({{"creases", "auto:30"}}, "creases: auto:30" + kNo);
  expect({{"compress", "meshopt"}}, "compress: meshopt" + kNo);
  expect({{"attributes", "error"}}, "attributes: error" + kNo);
  expect({{"chord_errors", {0.001}}}, "chord_errors: [0.001]" + kNo + "tiles have levels");
  expect({{"source", "n.obj"}}, "source: n.obj" + kNo);
  expect({{"page", "p.html"}}, "page: p.html" + kNo);
  const json none = json::object();
  EXPECT_THAT(scene_refusal(none, "t.glb"), HasSubstr("jobs[0].outputs[1]: t.glb: ranks write"));
  EXPECT_THAT(scene_refusal(none, "t.obj", "cage"), HasSubstr("ranks write cages as .ply only"));
  EXPECT_THAT(scene_refusal(none, "u.ply", "cage"), HasSubstr("ranks write one cage of a mesh"));
  EXPECT_THAT(scene_refusal({{"levels", {0}}}), HasSubstr("3D Tiles have levels from 1 on"));
}

TEST(MpiOptions, FlagsOfRanksAreChecked) {
  const auto with = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", "m.obj", "--cage", "c.ply"});
    return refusal_of(more);
  };
  EXPECT_EQ(with({"--partition", "hilbert"}), "");
  EXPECT_THAT(with({"--partition", "ptscotch"}), StartsWith("--partition: ptscotch" + kNo));
  EXPECT_THAT(with({"--watchdog", "-1"}), StartsWith("--watchdog: "));
  EXPECT_THAT(with({"--block-vertices", "0"}), StartsWith("--block-vertices: "));
  EXPECT_THAT(with({"-o", "x.json", "--block-vertices", "9"}), StartsWith("--block-vertices: "));
  EXPECT_THAT(with({"-o", "x.json", "--levels", "0"}), StartsWith("--levels: "));
  EXPECT_THAT(with({"--skirts"}), StartsWith("--skirts: belongs to 3D Tiles"));
  EXPECT_THAT(with({"--resume"}), StartsWith("--resume: belongs to 3D Tiles"));
  EXPECT_THAT(with({"--polish", "3"}), StartsWith("--polish: belongs to the fair method"));
  EXPECT_THAT(with({"--solver", "cg"}), StartsWith("--solver: cg"));
  EXPECT_THAT(with({"--scheme", "loop"}), StartsWith("--scheme: loop"));
  EXPECT_THAT(with({"--repair", "safe"}), StartsWith("--repair: safe"));
  EXPECT_THAT(with({"--device", "vulkan"}), StartsWith("--device: vulkan"));
  EXPECT_THAT(with({"--precision", "float"}), StartsWith("--precision: float"));
  EXPECT_THAT(with({"--creases", "auto"}), StartsWith("--creases: auto"));
  EXPECT_THAT(with({"n.obj"}), StartsWith("INPUT: 2 meshes"));
  EXPECT_THAT(with({"-o", "a.json", "-o", "b.json"}), HasSubstr("one set of tiles"));
}

}  // namespace
}  // namespace planish::test
