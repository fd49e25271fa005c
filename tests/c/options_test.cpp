// Options by name, as planish.h has them: each row of the library's table is served or refused by
// name, and means what it means to the command.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <planish/c/planish.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/files/mesh_file.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"
#include "support/files.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

struct Free {
  void operator()(planish_options* options) const { planish_options_free(options); }
};
using OwnOptions = std::unique_ptr<planish_options, Free>;

OwnOptions defaults() {
  planish_options* made = nullptr;
  EXPECT_EQ(planish_options_create(&made), PLANISH_OK);
  return OwnOptions(made);
}

void set(const OwnOptions& options, std::string_view name, const std::string& value) {
  EXPECT_EQ(planish_options_set(options.get(), std::string(name).c_str(), value.c_str()),
            PLANISH_OK)
      << planish_last_error();
}

std::string text(const OwnOptions& options, std::string_view name) {
  const char* value = nullptr;
  EXPECT_EQ(planish_options_get(options.get(), std::string(name).c_str(), &value), PLANISH_OK)
      << planish_last_error();
  return value != nullptr ? value : "?";
}

// What is said of a value, which has to be refused, and to change nothing.
std::string refusal(const OwnOptions& options, std::string_view name, const char* value) {
  EXPECT_EQ(planish_options_set(options.get(), std::string(name).c_str(), value),
            PLANISH_INVALID_ARGUMENT)
      << name << " " << value;
  return planish_last_error();
}

// A value that is taken, and not the default where there is another.
std::string good_value(const FitOption& option) {
  if (option.name == "device") return "cpu";
  if (!option.example.empty()) return std::string(option.example);
  if (!option.words.empty()) return std::string(option.words.back());
  return std::string(option.initial);
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// But tags, which name vertices.
TEST(COptions, EveryRowIsServed) {
  std::vector<std::string_view> refused;
  for (const FitOption& option : option_table()) {
    SCOPED_TRACE(option.name);
    const OwnOptions options = defaults();
    const std::string name(option.name), value = good_value(option);
    if (planish_options_set(options.get(), name.c_str(), value.c_str()) != PLANISH_OK) {
      refused.push_back(option.name);
      EXPECT_THAT(planish_last_error(), StartsWith("options." + name + ": this interface"));
      EXPECT_THAT(planish_last_error(), HasSubstr("planish run does it"));
      const char* unset = nullptr;
      EXPECT_EQ(planish_options_get(options.get(), name.c_str(), &unset), PLANISH_INVALID_ARGUMENT);
      continue;
    }
    FitSettings settings;
    read_option(option, settings, value, "test");
    EXPECT_EQ(text(options, name), option.get ? option.get(settings) : value);
  }
  EXPECT_THAT(refused, ElementsAre("crease_edges", "corner_vertices"));
  for (const PointOption& option : point_option_table()) {
    const OwnOptions options = defaults();
    const std::string value(option.example.empty() ? option.initial : option.example);
    set(options, option.name, option.words.empty() ? value : std::string(option.words.back()));
  }
}

TEST(COptions, WhatMeshesHaveNotIsRefusedForThem) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "cube.obj";
  write_mesh(path, FileFormat::Obj, cube());
  planish_mesh* mesh = nullptr;
  ASSERT_EQ(planish_mesh_read(path.c_str(), &mesh), PLANISH_OK);
  planish_fit* fit = nullptr;
  for (const auto& [name, value, what] : {std::array{"outliers", "off", "points; take"},
                                          {"page", "p.html", ""},
                                          {"cage", "c.obj", ""}}) {
    const OwnOptions options = defaults();
    set(options, name, value);
    EXPECT_EQ(planish_fit_create(mesh, options.get(), &fit), PLANISH_INVALID_ARGUMENT);
    EXPECT_THAT(planish_last_error(), AllOf(StartsWith("options." + std::string(name) + ": is of "),
                                            HasSubstr(what), HasSubstr("planish_fit_file()")));
  }
  planish_mesh_free(mesh);
}

// What is of files goes with a fit to the files that are written of it.
TEST(COptions, FilesOfAFitAreAsItsOptionsSay) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "cube.obj", plain = folder.path() / "a.glb",
                    packed = folder.path() / "b.glb", tiles = folder.path() / "t.json";
  write_mesh(path, FileFormat::Obj, cube());
  planish_mesh* mesh = nullptr;
  ASSERT_EQ(planish_mesh_read(path.c_str(), &mesh), PLANISH_OK);
  planish_fit* fit = nullptr;
  const OwnOptions options = defaults();
  set(options, "compress", "meshopt");
  ASSERT_EQ(planish_fit_create(mesh, nullptr, &fit), PLANISH_OK);
  EXPECT_EQ(planish_fit_write(fit, 3, plain.c_str()), PLANISH_OK);
  planish_fit_free(fit);
  ASSERT_EQ(planish_fit_create(mesh, options.get(), &fit), PLANISH_OK);
  EXPECT_EQ(planish_fit_write(fit, 3, packed.c_str()), PLANISH_OK);
  EXPECT_EQ(planish_fit_write(fit, 2, tiles.c_str()), PLANISH_OK);
  EXPECT_LT(std::filesystem::file_size(packed), std::filesystem::file_size(plain));
  EXPECT_TRUE(std::filesystem::exists(tiles));
  EXPECT_EQ(planish_fit_write(fit, 7, plain.c_str()), PLANISH_INVALID_ARGUMENT);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
}

TEST(COptions, LimitsEndWhatNeedsMore) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "cube.obj", output = folder.path() / "a.glb";
  write_mesh(path, FileFormat::Obj, cube());
  const auto status_with = [&](const char* name, const char* value) {
    const OwnOptions options = defaults();
    set(options, name, value);
    return planish_fit_file(path.c_str(), output.c_str(), options.get(), nullptr);
  };
  EXPECT_EQ(status_with("point_limit", "7"), PLANISH_NO_MEMORY);
  EXPECT_EQ(status_with("memory_limit", "1000"), PLANISH_NO_MEMORY);
  EXPECT_EQ(status_with("output_limit", "1000"), PLANISH_UNWRITABLE_OUTPUT);
  EXPECT_FALSE(std::filesystem::exists(output));
  EXPECT_EQ(status_with("point_limit", "8"), PLANISH_OK);
}

// The third cannot be fitted, and stops nobody.
TEST(COptions, ManyFilesHaveAContactSheet) {
  const TemporaryFolder folder;
  const auto inside = [&](const char* name) { return (folder.path() / name).string(); };
  const std::array<std::string, 3> paths{inside("cube.obj"), inside("torus.obj"),
                                         inside("bad.obj")};
  write_mesh(paths[0], FileFormat::Obj, cube());
  write_mesh(paths[1], FileFormat::Obj, torus(8, 6, 1, 0.4));
  std::ofstream(paths[2]) << "no mesh";
  const std::array<const char*, 3> inputs{paths[0].c_str(), paths[1].c_str(), paths[2].c_str()};
  const OwnOptions options = defaults();
  set(options, "page", inside("pages"));
  std::vector<std::pair<std::size_t, std::string>> failures;
  const auto note = [](void* user, std::size_t input, const char* message) {
    static_cast<decltype(failures)*>(user)->emplace_back(input, message);
  };
  ASSERT_EQ(planish_fit_files(inputs.data(), 3, inside("out").c_str(), "ply", options.get(), note,
                              &failures),
            PLANISH_OK)
      << planish_last_error();
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_EQ(failures[0].first, 2u);
  EXPECT_THAT(failures[0].second, HasSubstr("bad.obj"));
  for (const char* name : {"out/cube.ply", "out/torus.ply", "pages/cube.html", "pages/torus.html"})
    EXPECT_TRUE(std::filesystem::exists(inside(name))) << name;
  std::ifstream sheet(inside("pages/index.html"));
  const std::string html{std::istreambuf_iterator<char>(sheet), {}};
  EXPECT_THAT(html, AllOf(HasSubstr("torus.html"), HasSubstr("bad")));
  // Without a folder of pages, an extension and anybody to tell.
  EXPECT_EQ(
      planish_fit_files(inputs.data(), 2, inside("b").c_str(), nullptr, nullptr, nullptr, nullptr),
      PLANISH_OK);
  EXPECT_TRUE(std::filesystem::exists(inside("b/torus.glb")));
  set(options, "report", "r.json");
  EXPECT_EQ(planish_fit_files(inputs.data(), 3, inside("c").c_str(), nullptr, options.get(),
                              nullptr, nullptr),
            PLANISH_INVALID_ARGUMENT);
  EXPECT_THAT(planish_last_error(), StartsWith("options.report: is of one file"));
}

TEST(COptions, UnknownNamesAreToldTheNearest) {
  const OwnOptions options = defaults();
  EXPECT_EQ(refusal(options, "tolerence", "1"),
            "options.tolerence: there is no such option here; did you mean tolerance?");
  EXPECT_THAT(refusal(options, "thread", "1"), HasSubstr("did you mean threads?"));
  EXPECT_THAT(refusal(options, "max-iterations", "1"), HasSubstr("did you mean max_iterations?"));
  EXPECT_THAT(refusal(options, "\x1b", "1"), StartsWith("options.\\x1b: there is no"));
  EXPECT_THAT(refusal(options, "", "1"), HasSubstr("planish fit --help"));
}

TEST(COptions, DefaultsAreTheTables) {
  const OwnOptions options = defaults();
  const FitSettings settings;
  int compared = 0;
  for (const FitOption& option : option_table()) {
    const char* value = nullptr;
    const std::string name(option.name);
    if (!option.get || name == "device" ||
        planish_options_get(options.get(), name.c_str(), &value) != PLANISH_OK)
      continue;
    EXPECT_EQ(value, option.get(settings)) << name;
    ++compared;
  }
  EXPECT_GE(compared, 20);
  EXPECT_EQ(text(options, "weld"), "");
  EXPECT_EQ(text(options, "levels"), "");
  EXPECT_EQ(text(options, "threads"), "0");
  EXPECT_EQ(text(options, "device"), "cpu");
}

TEST(COptions, RefusedValuesLeaveWhatWasSet) {
  const OwnOptions options = defaults();
  set(options, "polish", "3");
  set(options, "threads", "2");
  EXPECT_EQ(refusal(options, "polish", "many"),
            "options.polish: \"many\" is no whole number; 0 to 1000 is wanted");
  EXPECT_EQ(refusal(options, "threads", "4097"),
            "options.threads: 4097 is out of range; 0 to 4096 is wanted");
  EXPECT_EQ(refusal(options, "threads", "-1"),
            "options.threads: -1 is out of range; 0 to 4096 is wanted");
  for (const char* device : {"vulkan", "auto", "0"})
    EXPECT_THAT(refusal(options, "device", device), HasSubstr("take cpu")) << device;
  EXPECT_EQ(text(options, "polish"), "3");
  EXPECT_EQ(text(options, "threads"), "2");
  EXPECT_EQ(text(options, "device"), "cpu");
}

// As on a command line, in which the order of flags says nothing.
TEST(COptions, APresetGivesWayToWhatIsSetBeside) {
  const OwnOptions before = defaults(), after = defaults();
  set(before, "preset", "paper");
  set(before, "solver", "cg");
  set(after, "solver", "cg");
  set(after, "preset", "paper");
  for (const OwnOptions* options : {&before, &after}) {
    EXPECT_EQ(text(*options, "solver"), "cg");
    EXPECT_EQ(text(*options, "weights"), "averaged");
    EXPECT_EQ(text(*options, "interpolation"), "progressive");
    EXPECT_EQ(text(*options, "preset"), "paper");
  }
}

TEST(COptions, NullIsRefused) {
  const OwnOptions options = defaults();
  const char* value = "as it was";
  EXPECT_EQ(planish_options_create(nullptr), PLANISH_INVALID_ARGUMENT);
  EXPECT_EQ(planish_options_set(nullptr, "polish", "1"), PLANISH_INVALID_ARGUMENT);
  EXPECT_EQ(planish_options_set(options.get(), nullptr, "1"), PLANISH_INVALID_ARGUMENT);
  EXPECT_EQ(planish_options_set(options.get(), "polish", nullptr), PLANISH_INVALID_ARGUMENT);
  EXPECT_STREQ(planish_last_error(), "value is NULL");
  EXPECT_EQ(planish_options_get(nullptr, "polish", &value), PLANISH_INVALID_ARGUMENT);
  EXPECT_EQ(planish_options_get(options.get(), "polish", nullptr), PLANISH_INVALID_ARGUMENT);
  EXPECT_STREQ(value, "as it was");
  planish_options_on_progress(nullptr, nullptr, nullptr);
  planish_options_on_warning(nullptr, nullptr, nullptr);
  planish_options_free(nullptr);
}

class COptionsOfFiles : public testing::Test {
 protected:
  COptionsOfFiles() { write_mesh(input_, FileFormat::Obj, test::cube()); }

  // What a file becomes, by planish_fit_file() and by planish_fit_write().
  std::string by_file(const OwnOptions& options, const std::filesystem::path& input,
                      const char* output) const {
    const std::filesystem::path path = folder_.path() / output;
    EXPECT_EQ(planish_fit_file(input.c_str(), path.c_str(), options.get(), nullptr), PLANISH_OK)
        << planish_last_error();
    return content_of(path);
  }
  std::string by_fit(const OwnOptions& options, const char* output) const {
    const std::filesystem::path path = folder_.path() / output;
    planish_mesh* mesh = nullptr;
    planish_fit* fit = nullptr;
    EXPECT_EQ(planish_mesh_read(input_.c_str(), &mesh), PLANISH_OK);
    EXPECT_EQ(planish_fit_create(mesh, options.get(), &fit), PLANISH_OK);
    EXPECT_EQ(planish_fit_write(fit, PLANISH_LEVEL_AUTO, path.c_str()), PLANISH_OK);
    planish_fit_free(fit);
    planish_mesh_free(mesh);
    return content_of(path);
  }

  const TemporaryFolder folder_;
  const std::filesystem::path input_ = folder_.path() / "input.obj";
};

TEST_F(COptionsOfFiles, UpTurnsGltfAndIsToldToUsd) {
  const OwnOptions upright = defaults(), turned = defaults();
  set(turned, "up", "z");
  const std::string as_it_is = by_file(upright, input_, "y.glb");
  EXPECT_NE(by_file(turned, input_, "z.glb"), as_it_is);
  EXPECT_NE(by_fit(turned, "z.glb"), by_fit(upright, "y.glb"));
  EXPECT_THAT(by_file(upright, input_, "y.usda"), HasSubstr("upAxis = \"Y\""));
  EXPECT_THAT(by_file(turned, input_, "z.usda"), HasSubstr("upAxis = \"Z\""));
  EXPECT_THAT(by_fit(turned, "z.usda"), HasSubstr("upAxis = \"Z\""));
}

// The finest is first, in whatever order they are named, as on a command line.
TEST_F(COptionsOfFiles, LevelsOfDetailAreSorted) {
  const OwnOptions options = defaults();
  set(options, "levels", "0");
  (void)by_file(options, input_, "asset.glb");
  const std::filesystem::path asset = folder_.path() / "asset.glb";
  set(options, "lods", "msft");
  set(options, "levels", "2,1,0");
  const std::string falling = by_file(options, asset, "falling.glb");
  EXPECT_THAT(falling, HasSubstr("MSFT_lod"));
  set(options, "levels", "0,2,1");
  EXPECT_EQ(by_file(options, asset, "mixed.glb"), falling);
}

}  // namespace
}  // namespace planish::test
