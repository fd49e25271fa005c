#include "planish/job/job_text.h"

#include <gmock/gmock.h>

#include "planish/core/error.h"

namespace planish::command {
namespace {

TEST(CageHeader, ReadsBackWhatItWrites) {
  FitSettings settings;
  settings.weights = Weights::Averaged;
  settings.boundary = BoundaryRule::EdgeAndCorner;
  settings.creases = {.dihedral_degrees = 32.5};
  settings.repair = RepairChoice::None;
  settings.tolerance = 1.0 / 3.0 * 1e-7;
  settings.weld = 1.0 / 3.0 * 1e-5;
  FoundCreases found{{}, {0, 17, 2147483647}};
  for (std::int32_t v = 0; v < 40; ++v) found.edges.push_back({v, v + 100});
  std::vector<std::string> lines =
      cage_header_lines(settings, InterpolationMethod::Fair, "some/where/goblet.obj", found);
  for (std::string& line : lines) EXPECT_EQ(line.substr(0, 8), "planish ");
  const CageHeader header = parse_cage_header(lines, "cage.obj");
  EXPECT_EQ(header.settings.interpolation, InterpolationChoice::Fair);
  EXPECT_EQ(header.settings.weights, Weights::Averaged);
  EXPECT_EQ(header.settings.boundary, BoundaryRule::EdgeAndCorner);
  EXPECT_EQ(header.settings.creases.dihedral_degrees, 32.5);
  EXPECT_EQ(header.settings.repair, RepairChoice::None);
  EXPECT_EQ(header.settings.tolerance, settings.tolerance);  // to the last bit
  EXPECT_EQ(header.source, "goblet.obj");
  EXPECT_EQ(header.settings.weld, settings.weld);
  ASSERT_TRUE(header.found);
  EXPECT_EQ(header.found->edges, found.edges) << "of three lines";
  EXPECT_EQ(header.found->corners, found.corners);
}

// Those of older versions are read: order and spelling stay.
TEST(CageHeader, HasItsLinesInOrder) {
  FitSettings settings;
  settings.creases = {.dihedral_degrees = 1e-5};
  settings.weld = 0;
  settings.scheme = Scheme::Loop;
  const std::vector<std::string> lines =
      cage_header_lines(settings, InterpolationMethod::Progressive, "a.obj");
  EXPECT_THAT(
      std::vector(lines.begin() + 1, lines.end()),
      testing::ElementsAre("planish scheme=loop", "planish interpolation=progressive",
                           "planish weights=doo-sabin", "planish boundary=edge",
                           "planish creases=auto:1e-05", "planish repair=safe",
                           "planish quads=auto", "planish refine=auto", "planish tolerance=1e-06",
                           "planish source=a.obj", "planish weld=0", "planish sharp_edges="));
  EXPECT_EQ(parse_cage_header(lines, "a").settings.creases.dihedral_degrees, 1e-5);
}

TEST(CageHeader, ASourceCannotBreakTheLine) {
  for (const std::string& line :
       cage_header_lines({}, InterpolationMethod::Progressive, "a\nv 1 2 3.obj")) {
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

TEST(CageHeader, SaysNothingWhereNothingStands) {
  const CageHeader header = parse_cage_header({}, "cage.obj");
  EXPECT_EQ(header.settings.interpolation, InterpolationChoice::Progressive);
  EXPECT_FALSE(header.settings.weld);
  EXPECT_EQ(header.settings.tolerance, FitSettings().tolerance);
  EXPECT_EQ(header.source, "");
  EXPECT_FALSE(header.found);
}

TEST(CageHeader, KeysOfNewerVersionsAreLeftToThem) {
  const std::vector<std::string> lines{"planish colour=blue", "planish weights=doo-sabin"};
  EXPECT_EQ(parse_cage_header(lines, "cage.obj").settings.weights, Weights::DooSabin);
}

TEST(CageHeader, WrongValuesAreNamed) {
  for (const char* line :
       {"planish weights=heavy", "planish tolerance=small", "planish tolerance=-1",
        "planish tolerance=1e-6x", "planish scheme=kobbelt", "planish weld=0.1", "planish weld=nan",
        "planish sharp_corners=1 x", "planish sharp_corners=-1", "planish sharp_corners=2147483648",
        "planish sharp_edges=1", "planish sharp_edges=1-x", "planish sharp_edges=1-2-3",
        "planish boundary=", "planish interpolation=auto"}) {
    const std::vector<std::string> lines{line};
    try {
      (void)parse_cage_header(lines, "cage.obj");
      FAIL() << line;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::UnreadableInput) << line;
      EXPECT_THAT(error.what(), testing::HasSubstr("cage.obj: header "));
    }
  }
}

}  // namespace
}  // namespace planish::command
