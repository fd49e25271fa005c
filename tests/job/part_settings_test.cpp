#include "planish/pipeline/part_settings.h"

#include <gmock/gmock.h>

#include <string>

#include "planish/pipeline/settings.h"
#include "support/calls.h"

namespace planish::test {
namespace {

using testing::HasSubstr;

std::string parsed(std::string_view text) {
  return part_settings_text(parse_part_settings(text, "set"));
}

// Names and values may have colons and signs.
TEST(PartSettings, AreReadFromTexts) {
  EXPECT_EQ(parsed("mesh=Wheel:creases=use"), "mesh=Wheel:creases=use");
  EXPECT_EQ(parsed(" node=A:b=c d:creases=auto:40 ;material=x=y:max-iterations:quads=on"),
            "node=A:b=c d:creases=auto:40; material=x=y:max-iterations:quads=on");
}

TEST(PartSettings, NameByStars) {
  const auto names = [](std::string_view pattern, std::string_view name) {
    return PartSetting{.name = std::string(pattern)}.names(name);
  };
  EXPECT_TRUE(names("Wheel", "Wheel"));
  EXPECT_FALSE(names("Wheel", "Wheel.001"));
  EXPECT_TRUE(names("Wheel*", "Wheel.001"));
  EXPECT_TRUE(names("Wheel*", "Wheel"));
  EXPECT_FALSE(names("Wheel*", "BigWheel"));
  EXPECT_TRUE(names("*", ""));
  EXPECT_TRUE(names("*_l*g", "upper_leg"));
  EXPECT_FALSE(names("a*a", "a"));
  EXPECT_TRUE(names("*a*b*", "xxabxx"));
  EXPECT_FALSE(names("*b*a*", "xxabxx"));
}

TEST(PartSettings, ApplyToAMesh) {
  FitSettings settings;
  for (const PartSetting& one :
       parse_part_settings("mesh=a:creases=auto:40; mesh=a:within=0.01; mesh=a:levels=3", "set"))
    one.apply_to(settings);
  EXPECT_EQ(settings.creases.dihedral_degrees, 40);
  EXPECT_EQ(settings.within.of_diagonal, 0.01);
  EXPECT_EQ(settings.levels, std::vector<int>{3});
  EXPECT_FALSE(settings.levels_by_density);
}

TEST(PartSettings, WhatIsNoneIsRefused) {
  const auto refusal = [](std::string_view text) {
    return message_of(ErrorCode::InvalidArgument, [&] { (void)parsed(text); });
  };
  EXPECT_THAT(refusal(""), HasSubstr("mesh=NAME:OPTION=VALUE is wanted"));
  EXPECT_THAT(refusal("mesh=a:quads=on;"), HasSubstr("is wanted"));
  EXPECT_THAT(refusal("mehs=a:quads=on"), HasSubstr("did you mean mesh?"));
  EXPECT_THAT(refusal("mesh=:quads=on"), HasSubstr("the name is empty"));
  EXPECT_THAT(refusal("mesh=a"), HasSubstr("is wanted"));
  EXPECT_THAT(refusal("mesh=a:compress=meshopt"),
              HasSubstr("parts have no \"compress\" of their own"));
  EXPECT_THAT(refusal("mesh=a:creases=auto:400"), HasSubstr("set mesh=a: \"400\" is no angle"));
}

}  // namespace
}  // namespace planish::test
