#include "planish/files/read_file.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace planish {
namespace {

std::optional<FileFormat> sniff(const std::string& content) {
  return sniff_format(std::as_bytes(std::span(content)));
}

TEST(SniffFormat, KnowsEveryFormatByItsFirstLines) {
  const std::vector<std::pair<std::string, FileFormat>> files{
      {"glTF\x02", FileFormat::Glb},
      {" \n{\"asset\":{}}", FileFormat::Gltf},
      {"# made by hand\n\nv 0 0 0\n", FileFormat::Obj},
      {"mtllib a.mtl\r\nv 0 0 0\r\n", FileFormat::Obj},
      {"ply\r\nformat ascii 1.0\r\n", FileFormat::Ply},
      {"OFF\n3 1 0\n", FileFormat::Off},
      {"COFF 3 1 0\n", FileFormat::Off},
      {"solid part\n facet normal", FileFormat::Stl},
      {"# .PCD v0.7 - Point Cloud Data\nVERSION 0.7\n", FileFormat::Pcd},
      {"LASF\1\2", FileFormat::Las},
      {"1204\n0 0 0 1 2 3\n", FileFormat::Pts},
      {"0\n2\n0 0 0\n", FileFormat::Pts},
      {"200\n100\n0 0 0\n", FileFormat::Ptx},
      {"# x y z\n0.5 -1e3 2\n", FileFormat::Xyz},
      {"0.5,1,2,255\n", FileFormat::Xyz}};
  for (const auto& [content, format] : files) EXPECT_EQ(sniff(content), format) << content;
}

TEST(SniffFormat, KnowsTextOfAnyEncodingAndLineEnd) {
  EXPECT_EQ(sniff("# made by hand\rv 0 0 0\r"), FileFormat::Obj);
  EXPECT_EQ(sniff("\xEF\xBB\xBFply\rformat ascii 1.0\r"), FileFormat::Ply);
  EXPECT_EQ(sniff("COFF BINARY\n\x01"), FileFormat::Off);
  std::string little, big;
  for (const char c : std::string("# made by hand\nsolid a\n")) {
    little += {c, '\0'};
    big += {'\0', c};
  }
  for (const std::string& wide : {"\xFF\xFE" + little, "\xFE\xFF" + big, little, big})
    EXPECT_EQ(sniff(wide), FileFormat::Stl);
}

TEST(SniffFormat, KnowsABinaryStlByItsSize) {
  std::string content(84 + 2 * 50, '\0');
  content.replace(0, 5, "solid");  // as some programs write into binary files
  content[80] = 2;
  EXPECT_EQ(sniff(content), FileFormat::Stl);
  content[80] = 3;
  content.replace(0, 5, "\0\0\0\0\0", 5);
  EXPECT_EQ(sniff(content), std::nullopt);
}

TEST(SniffFormat, SaysNothingOfWhatItDoesNotKnow) {
  for (const char* content : {"", "\n\n", "# only a comment\n", "hello world\n", "1 2\n", "PK\x03"})
    EXPECT_EQ(sniff(content), std::nullopt) << content;
}

TEST(SniffFormat, KnowsWhatStandsInThePlaceOfAFile) {
  const auto foreign = [](const std::string& content) {
    return std::string(foreign_content(std::as_bytes(std::span(content))));
  };
  EXPECT_NE(foreign("\x1f\x8b\x08").find("gunzip"), std::string::npos);
  EXPECT_NE(foreign("PK\x03\x04").find("unzip"), std::string::npos);
  EXPECT_NE(foreign("version https://git-lfs.github.com/spec/v1\n").find("git lfs pull"),
            std::string::npos);
  EXPECT_NE(foreign("<!DOCTYPE html><html>").find("web page"), std::string::npos);
  EXPECT_EQ(foreign("v 0 0 0\n"), "");
  EXPECT_EQ(foreign(""), "");
}

TEST(SniffFormat, KnowsPointsByTheNamesOfTheirColumns) {
  for (const char* text : {"X,Y,Z\n1,2,3\n", "\"X\";\"Y\";\"Z\"\n", "@File_Version: 4\n1 2 3\n"})
    EXPECT_EQ(sniff(text), FileFormat::Xyz) << text;
}

}  // namespace
}  // namespace planish
