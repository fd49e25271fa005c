#include <gmock/gmock.h>

#include <cstdint>
#include <fstream>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/files/formats.h"
#include "planish/job/input.h"
#include "planish/job/job_settings.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"
#include "scene_file.h"
#include "support/calls.h"

namespace planish::command {
namespace {

template <class Target>
void expect_defaults(const std::vector<Option<Target>>& table, const Target& defaults) {
  for (const Option<Target>& option : table) {
    if (option.initial.empty() || option.kind == OptionKind::Switch) continue;
    Target target = defaults;
    EXPECT_NO_THROW(read_option(option, target, option.initial, "here")) << option.name;
    if (option.get) {
      EXPECT_EQ(option.get(target), option.get(defaults)) << option.name;
    }
  }
}

TEST(Settings, EveryDefaultIsWhatTheTableSays) {
  expect_defaults(option_table(), FitSettings());
  expect_defaults(point_option_table(), Settings().points);
}

// As scene files, help and schemas need it.
template <class Target>
void expect_complete(const std::vector<Option<Target>>& table) {
  for (const Option<Target>& option : table) {
    EXPECT_FALSE(option.help.empty()) << option.name;
    const bool is_shown = option.kind != OptionKind::Switch &&
                          option.kind != OptionKind::Vertices && option.kind != OptionKind::Edges;
    EXPECT_EQ(choices_of(option).empty(), !is_shown) << option.name;
    const bool has_example =
        !option.initial.empty() || !option.example.empty() || !option.words.empty();
    EXPECT_TRUE(has_example) << option.name;
    EXPECT_EQ(find_option(table, option.name), &option);
  }
}

TEST(Settings, EveryRowIsComplete) {
  expect_complete(option_table());
  expect_complete(point_option_table());
}

template <class Target>
void expect_refusals(const std::vector<Option<Target>>& table) {
  for (const Option<Target>& option : table) {
    if (option.name == "device") continue;  // names are matched with devices later
    if (option.kind == OptionKind::Switch) continue;
    Target target;
    EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                                 [&] { read_option(option, target, "nonsense", "here"); }),
                testing::StartsWith("here: "))
        << option.name;
  }
}

TEST(Settings, NonsenseIsRefusedWithItsPlace) {
  expect_refusals(option_table());
  expect_refusals(point_option_table());
}

// Headers of cages and reports say it so.
TEST(Settings, TextsReadBack) {
  for (const FitOption& option : option_table()) {
    if (!option.get) continue;
    std::vector<std::string> texts(option.words.begin(), option.words.end());
    if (option.name == "creases")
      texts = {"choose", "use", "ignore", "normals", "auto:30", "auto:1e-05"};
    if (option.kind == OptionKind::Number) texts = {"0.012345678901234567", "1e-07"};
    for (const std::string& text : texts) {
      FitSettings settings, again;
      read_option(option, settings, text, "");
      const std::string first = option.get(settings);
      read_option(option, again, first, "");
      EXPECT_EQ(option.get(again), first);
      if (option.kind != OptionKind::Number) {
        EXPECT_EQ(first, text);
      }
    }
  }
  FitSettings settings;
  read_option(fit_option("creases"), settings, "auto", "");
  EXPECT_EQ(option_text(settings, "creases"), "auto");
  EXPECT_EQ(option_text({}, "weld"), "");
}

TEST(Settings, AutoPrecisionIsDoubleBelow1e8) {
  Settings settings;
  EXPECT_EQ(solve_precision(settings), Precision::Float);
  settings.tolerance = 1e-8;
  EXPECT_EQ(solve_precision(settings), Precision::Float);
  settings.tolerance = 0.99e-8;
  EXPECT_EQ(solve_precision(settings), Precision::Double);
  settings.precision = PrecisionChoice::Float;
  EXPECT_EQ(solve_precision(settings), Precision::Float);
}

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<Job> parse(const std::string& text) { return parse_scene(text, "s.json", "dir"); }

std::string message_of(const std::string& text) {
  return test::message_of(ErrorCode::InvalidArgument, [&] { (void)parse(text); });
}

// A scene of one job, and of a job with an input and more.
std::string scene_of(const std::string& job, const std::string& defaults = "{}") {
  return R"({"version":1,"defaults":)" + defaults + R"(,"jobs":[)" + job + "]}";
}
std::string scene_with(const std::string& more) {
  return scene_of(R"({"input":"a.obj",)" + more + "}");
}

TEST(SceneFile, ReadsTheDocumentedExample) {
  const std::vector<Job> jobs = parse(R"({"version":1,
    "defaults":{"tolerance":1e-5,"levels":[2],"device":"auto"},
    "jobs":[{"name":"goblet","input":"goblet.obj",
             "solve":{"solver":"plain","weights":"averaged"},
             "outputs":[{"path":"out/goblet.glb","levels":[3,1]},
                        {"path":"out/goblet_cage.obj","what":"cage"},
                        {"path":"out/goblet.ply"}],
             "report":"out/goblet.json"}]})");
  ASSERT_EQ(jobs.size(), 1u);
  const Job& job = jobs[0];
  EXPECT_EQ(job.name, "goblet");
  EXPECT_EQ(job.input, "dir/goblet.obj");
  EXPECT_EQ(job.settings.tolerance, 1e-5);
  EXPECT_EQ(job.settings.solver, Solver::Plain);
  EXPECT_EQ(job.settings.weights, Weights::Averaged);
  ASSERT_EQ(job.outputs.size(), 3u);
  EXPECT_EQ(job.outputs[0].path, "dir/out/goblet.glb");
  EXPECT_THAT(job.outputs[0].levels, ElementsAre(3, 1));
  EXPECT_EQ(job.outputs[1].kind, OutputKind::Cage);
  EXPECT_THAT(job.outputs[2].levels, ElementsAre(2));
  EXPECT_EQ(job.report, "dir/out/goblet.json");
  EXPECT_EQ(parse(scene_of(R"({"input":"/a.obj"})"))[0].input, "/a.obj");
  EXPECT_EQ(parse_scene(scene_of(R"({"input":"a.obj"})"), "s.json", "")[0].input, "a.obj");
}

// For who has not all settings, and refuses one by its place.
TEST(SceneFile, SaysWhereSettingsStandAndWhatTheyAre) {
  const std::vector<Job> jobs = parse(
      "{\"version\":1,\n\"defaults\":{\"skirts\":true},\n"
      "\"jobs\":[{\"input\":\"a.obj\",\n"
      "\"solve\":{\n\"solver\":\"plain\"},\n"
      "\"levels\":[3,1],\"source\":\"b.obj\"}]}");
  std::vector<std::string> given;
  for (const GivenSetting& one : jobs.at(0).given)
    given.push_back(one.name + " " + one.where + " " + one.value);
  EXPECT_THAT(given, ElementsAre("skirts s.json:2: defaults.skirts true",
                                 "solver s.json:5: jobs[0].solve.solver plain",
                                 "levels s.json:6: jobs[0].levels [3,1]",
                                 "source s.json:6: jobs[0].source b.obj"));
}

TEST(SceneFile, JobsOverrideDefaultsAndPresetsComeFirst) {
  const FitSettings settings =
      parse(scene_of(R"({"input":"a.obj","solve":{"preset":"paper","solver":"cg"}})",
                     R"({"weights":"doo-sabin","solve":{"max_iterations":7}})"))[0]
          .settings;
  EXPECT_EQ(settings.weights, Weights::Averaged);
  EXPECT_EQ(settings.solver, Solver::ConjugateGradients);
  EXPECT_EQ(settings.max_iterations, 7);
  EXPECT_EQ(settings.interpolation, InterpolationChoice::Progressive);
}

TEST(SceneFile, MistakesAreNamedWithPlaceAndLine) {
  struct Row {
    std::string scene, message;
  };
  const std::string whole = "{\"version\":1,\n\"jobs\":[{\"input\":\"a.obj\"}]}\n";
  for (const Row& row : std::vector<Row>{
           // The frame.
           {"{}", "s.json: has no \"version\""},
           {R"({"version":2,"jobs":[]})", "s.json:1: version: 2 is not known"},
           {R"({"version":1,"version":1})", "stands twice"},
           {R"({"version":1})", "s.json: has no \"jobs\""},
           {R"({"version":1,"jobs":[]})", "s.json:1: jobs: is empty"},
           {R"({"version":1,"jobs":[{"input":"a.obj"},{"input":"b/a.obj"}]})",
            "s.json:1: jobs[1].name: \"a\" is the name of an earlier job"},
           // Unknown keys name the nearest.
           {R"({"version":1,"jbos":[]})",
            "s.json:1: jbos: this key is not known; did you mean jobs?"},
           {scene_with(R"("solve":{"wieghts":"averaged"})"),
            "s.json:1: jobs[0].solve.wieghts: this key is not known; did you mean weights?"},
           {scene_with(R"("outputs":[{"pth":"a.glb"}])"),
            "s.json:1: jobs[0].outputs[0].pth: this key is not known; did you mean path?"},
           {scene_of(R"({"input":"a.obj"})", R"({"tolerence":1})"),
            "s.json:1: defaults.tolerence: "},
           // Lines.
           {"{\"version\": 1,\n \"jobs\": [\n  {\"input\": \"a, \\\"[{:\\\".obj\"},\n"
            "  {\"input\": \"b.obj\",\n   \"levels\": [1,\n    9]}]}",
            "s.json:5: jobs[1].levels: 9 is out of range"},
           {"{\n\"version\": 1,\n\"jobs\": [{},\n{\"outptus\": []}]}", "s.json:3: jobs[0]: has no"},
           {"{\n\"version\": 1,\n\"jobs\": [{\"input\": \"a.obj\"},\n{\"outptus\": []}]}",
            "s.json:4: jobs[1].outptus: this key is not known"},
           // What is no JSON.
           {"{\n\"version\": 1,\n oops\n}", "s.json:3: no valid JSON here"},
           {whole + '\0' + "}", "s.json:3: no valid JSON here"},
           {"", "s.json"},
           {"[", "s.json"},
           {"nul", "s.json"},
           {"{\"version\":1", "s.json"},
           {"\"\\uD800\"", "s.json"},
           {"\xFF\xFE", "s.json"},
           {"1e999", "s.json"},
           // Wrong types.
           {scene_of("[]"), "s.json:1: jobs[0]: an object is wanted"},
           {scene_of("null"), "s.json:1: jobs[0]: an object is wanted"},
           {scene_of(R"({"input":7})"), "s.json:1: jobs[0].input: a text is wanted, not number"},
           {scene_with(R"("tolerance":"1e-6")"), "jobs[0].tolerance: a number is wanted"},
           {scene_with(R"("max_iterations":1.5)"), "jobs[0].max_iterations: a whole number"},
           {scene_with(R"("polish":1.5)"), "jobs[0].polish: a whole number"},
           {scene_with(R"("max_iterations":1e300)"), "jobs[0].max_iterations: a whole number"},
           {scene_with(R"("max_iterations":18446744073709551615)"),
            "jobs[0].max_iterations: a whole number"},
           {scene_with(R"("levels":2)"), "jobs[0].levels: a list of levels"},
           {scene_with(R"("levels":[2,"3"])"), "jobs[0].levels[1]: a whole number"},
           {scene_with(R"("levels":[])"), "jobs[0].levels: no level is named"},
           {scene_with(R"("solve":[])"), "jobs[0].solve: an object is wanted"},
           {scene_with(R"("outputs":"a.glb")"), "jobs[0].outputs: a list is wanted"},
           {scene_with(R"("outputs":["a.glb"])"), "jobs[0].outputs[0]: an object is wanted"},
           {scene_with(R"("weights":null)"), "jobs[0].weights: a text is wanted"},
           // Wrong values.
           {scene_of(R"({"name":"a"})"), "jobs[0]: has no \"input\""},
           {scene_of(R"({"input":""})"), "jobs[0].input: is empty"},
           {scene_of(R"({"input":"-"})"), "jobs[0].input: a file is wanted"},
           {scene_with(R"("interpolation":"fare")"), "did you mean fair?"},
           {scene_with(R"("polish":-1)"), "jobs[0].polish: -1 is out of range"},
           {scene_with(R"("levels":[9])"), "jobs[0].levels: 9 is out of range"},
           {scene_with(R"("tolerance":0)"), "jobs[0].tolerance: 0 is out of range"},
           {scene_with(R"("weld":-1e-6)"), "jobs[0].weld: "},
           {scene_with(R"("solve":{"weld":0.1})"), "jobs[0].solve.weld: "},
           {scene_with(R"("weld":"little")"), "jobs[0].weld: "},
           {scene_with(R"("weld":null)"), "jobs[0].weld: "},
           {scene_with(R"("weights":"averaged","solve":{"weights":"averaged"})"),
            "jobs[0].solve.weights: stands in"},
           {scene_with(R"("outputs":[{"path":"c.obj","what":"cage","levels":[1]}])"),
            "jobs[0].outputs[0].levels: a cage has no levels"},
           {scene_with(R"("outputs":[{"path":"c.obj","what":"cgae"}])"), "did you mean cage?"},
           {scene_with(R"("device":"vulkan","precision":"double")"), "jobs[0]: --precision"},
#ifdef PLANISH_HAS_MESHER
           {scene_of(R"({"input":"a.xyz","moves":[{"undo":1}]})"),
            "jobs[0].moves: are of vertices of a mesh"},
#endif
       })
    EXPECT_THAT(message_of(row.scene), HasSubstr(row.message)) << row.scene;
}

TEST(SceneFile, DeepNestingIsRefused) {
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  for (const std::string& deep : {std::string(1'000'000, '['), objects})
    EXPECT_EQ(message_of(deep), "s.json: is nested too deeply to be a scene");
}

TEST(SceneFile, JobsAreSelectedByName) {
  const auto jobs = [] { return parse(scene_of(R"({"input":"one.obj"},{"input":"two.obj"})")); };
  EXPECT_EQ(select_jobs(jobs(), {}).size(), 2u);
  EXPECT_EQ(select_jobs(jobs(), {"two"}).at(0).name, "two");
  EXPECT_THAT(
      test::message_of(ErrorCode::InvalidArgument, [&] { (void)select_jobs(jobs(), {"tow"}); }),
      HasSubstr("it has one, two; did you mean two?"));
}

TEST(SceneFile, ReadsMoves) {
  const Job job = parse(R"({"version":1,"jobs":[{"input":"a.obj","moves":[
        {"vertices":[4,2],"to":[[1,2,3],[4,5,6]]},
        {"vertices":[7],"by":[0,0.5,0],"radius":2},
        {"vertices":[],"matrix":[[1,2,3,4],[5,6,7,8],[9,10,11,12]]},
        {"undo":3}]}]})")
                      .at(0);
  ASSERT_EQ(job.moves.size(), 4u);
  EXPECT_THAT(job.moves[0].vertices, ElementsAre(4, 2));
  EXPECT_THAT(job.moves[0].to, ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6)));
  EXPECT_EQ(job.moves[1].map * glm::dvec4(1, 1, 1, 1), glm::dvec4(1, 1.5, 1, 1));
  EXPECT_EQ(job.moves[1].radius, 2);
  EXPECT_EQ(job.moves[2].map * glm::dvec4(1, 0, 2, 1), glm::dvec4(11, 27, 43, 1));
  EXPECT_EQ(job.moves[3].undo, 3);
  EXPECT_EQ(job.moves[3].where, "s.json:5: jobs[0].moves[3]");
  for (const auto& [move, message] : std::vector<std::pair<std::string, const char*>>{
           {R"("by":[0,0,1])", "moves[0]: has no \"vertices\""},
           {R"("vertices":[1])", "moves[0]: one of \"to\", \"by\""},
           {R"("vertices":[1],"by":[0,0,1],"to":[[0,0,1]])", "moves[0]: one of \"to\""},
           {R"("vertices":[1],"to":[[0,0,1],[0,0,2]])", "moves[0].to: 2 positions stand there"},
           {R"("vertices":[1],"to":[[0,0]])", "moves[0].to[0]: 3 numbers are wanted"},
           {R"("vertices":[1],"to":[[0,0,1]],"radius":1)", "moves[0].radius: goes with"},
           {R"("vertices":[-1],"by":[0,0,1])", "moves[0].vertices[0]: -1 is not from 0"},
           {R"("vertices":[1],"by":[0,0,1],"undo":1)", "moves[0]: \"undo\" stands by itself"},
           {R"("vertices":[1],"bye":[0,0,1])", "did you mean by?"},
       })
    EXPECT_THAT(message_of(scene_with(R"("moves":[{)" + move + "}]")), HasSubstr(message));
}

// ---- the published schema against the parser ----

json scene_schema() {
  std::ifstream file(PLANISH_SCENE_SCHEMA);
  return json::parse(file);
}

TEST(SceneSchema, NamesTheFormatsOfTheTable) {
  const json document = scene_schema();
  const json& job = document["$defs"]["job"]["properties"];
  std::string formats;
  for (const auto& name : job["input_format"]["enum"])
    formats += (formats.empty() ? "" : ", ") + name.get<std::string>();
  EXPECT_EQ(formats, names_of(FormatUse::Read));
  const json& output = document["$defs"]["output"]["properties"];
  EXPECT_THAT(output["path"]["description"].get<std::string>(),
              HasSubstr(extensions_of(FormatUse::WriteSurface)));
  EXPECT_THAT(output["what"]["description"].get<std::string>(),
              HasSubstr(extensions_of(FormatUse::WriteMesh)));
}

// A property's own description where it is a reference.
json resolved(const json& property, const json& document) {
  if (!property.contains("$ref")) return property;
  const std::string pointer = property["$ref"].get<std::string>().substr(1);
  return resolved(document.at(json::json_pointer(pointer)), document);
}

// A scene in which `value` stands as `key` of that kind of object.
json scene_holding(SceneObject object, const std::string& key, const json& value) {
  json scene = json::parse(scene_with(R"("outputs":[{"path":"a.glb"}])"));
  json& job = scene["jobs"][0];
  switch (object) {
    case SceneObject::Scene:
      scene[key] = value;
      break;
    case SceneObject::Defaults:
      scene["defaults"][key] = value;
      break;
    case SceneObject::Job:
      job[key] = value;
      break;
    case SceneObject::Solve:
      job["solve"][key] = value;
      break;
    case SceneObject::Output:
      job["outputs"][0][key] = value;
      break;
    case SceneObject::Move: {
      json& move = job["moves"][0];
      if (key != "undo") move["vertices"] = {17, 18};
      if (key == "vertices" || key == "radius") move["by"] = {0, 0, 1};
      move[key] = value;
      break;
    }
  }
  if (value == "cage") job["outputs"][0]["path"] = "a.obj";
  return scene;
}

const std::vector<std::pair<SceneObject, std::string>> kSchemaObjects{
    {SceneObject::Scene, ""},
    {SceneObject::Defaults, "/$defs/settings"},
    {SceneObject::Job, "/$defs/job"},
    {SceneObject::Solve, "/$defs/solve"},
    {SceneObject::Output, "/$defs/output"},
    {SceneObject::Move, "/$defs/move"}};

TEST(SceneSchema, HasTheKeysOfTheParserAndNoOthers) {
  const json document = scene_schema();
  for (const auto& [object, pointer] : kSchemaObjects) {
    const json& description = document.at(json::json_pointer(pointer));
    EXPECT_EQ(description["additionalProperties"], false) << pointer;
    std::vector<std::string> keys;
    for (const auto& [key, value] : description["properties"].items()) keys.push_back(key);
    const std::vector<std::string_view> known = scene_keys(object);
    EXPECT_THAT(keys, testing::UnorderedElementsAreArray(known.begin(), known.end())) << pointer;
  }
}

TEST(SceneSchema, EveryValueThatItAllowsIsAccepted) {
  const json document = scene_schema();
  for (const auto& [object, pointer] : kSchemaObjects) {
    for (const auto& [key, property] :
         document.at(json::json_pointer(pointer))["properties"].items()) {
      const json description = resolved(property, document);
      std::vector<json> values = description.value("examples", std::vector<json>{});
      EXPECT_FALSE(values.empty()) << key;
      for (const json& value : description.value("enum", json::array())) values.push_back(value);
      for (const char* limit : {"maximum", "minimum", "default"}) {
        if (description.contains(limit)) values.push_back(description[limit]);
      }
      for (const json& value : values) {
#ifndef PLANISH_HAS_MESHER
        if (key == "input_format" &&
            is_point_path("", parse_input_format(value.get<std::string>(), key))) {
          EXPECT_THROW((void)parse(scene_holding(object, key, value).dump()), Error);
          continue;
        }
#endif
        EXPECT_NO_THROW((void)parse(scene_holding(object, key, value).dump()))
            << pointer << ' ' << key << ' ' << value;
      }
    }
  }
}

TEST(SceneSchema, WhatItForbidsIsRefused) {
  const json document = scene_schema();
  for (const auto& [object, pointer] : kSchemaObjects) {
    for (const auto& [key, property] :
         document.at(json::json_pointer(pointer))["properties"].items()) {
      if (key == "$schema") continue;  // for editors only
      const json description = resolved(property, document);
      const bool is_switch = description.value("type", json()) == "boolean";
      std::vector<json> values{is_switch ? json("yes") : json(true), json()};
      if (description.contains("enum")) values.emplace_back("nonsense");
      if (description.contains("maximum"))
        values.emplace_back(description["maximum"].get<std::int64_t>() + 1);
      if (description.contains("minimum"))
        values.emplace_back(description["minimum"].get<std::int64_t>() - 1);
      if (description.contains("exclusiveMinimum"))
        values.emplace_back(description["exclusiveMinimum"]);
      if (description.contains("minLength")) values.emplace_back("");
      if (description.contains("minItems")) values.push_back(json::array());
      for (const json& value : values) {
        EXPECT_THROW((void)parse(scene_holding(object, key, value).dump()), Error)
            << pointer << ' ' << key << ' ' << value;
      }
    }
  }
}

}  // namespace
}  // namespace planish::command
