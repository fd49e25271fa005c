#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "files/gltf/asset_sample.h"
#include "files/read_bytes.h"
#include "planish/core/words.h"
#include "planish/files/materials.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

std::optional<FileFormat> sniff(const std::string& content) {
  return sniff_format(test::bytes_of(content));
}

TEST(SniffFormat, KnowsEveryFormatByItsFirstLines) {
  const std::vector<std::pair<std::string, std::optional<FileFormat>>> files{
      {"glTF\x02", FileFormat::Glb},
      {" \n{\"asset\":{}}", FileFormat::Gltf},
      {"# made by hand\n\nv 0 0 0\n", FileFormat::Obj},
      {"# made by hand\rv 0 0 0\r", FileFormat::Obj},
      {"mtllib a.mtl\r\nv 0 0 0\r\n", FileFormat::Obj},
      {"ply\r\nformat ascii 1.0\r\n", FileFormat::Ply},
      {"\xEF\xBB\xBFply\rformat ascii 1.0\r", FileFormat::Ply},
      {"OFF\n3 1 0\n", FileFormat::Off},
      {"COFF 3 1 0\n", FileFormat::Off},
      {"COFF BINARY\n\x01", FileFormat::Off},
      {"solid part\n facet normal", FileFormat::Stl},
      {"# .PCD v0.7 - Point Cloud Data\nVERSION 0.7\n", FileFormat::Pcd},
      {"LASF\1\2", FileFormat::Las},
      {"1204\n0 0 0 1 2 3\n", FileFormat::Pts},
      {"0\n2\n0 0 0\n", FileFormat::Pts},
      {"200\n100\n0 0 0\n", FileFormat::Ptx},
      {"# x y z\n0.5 -1e3 2\n", FileFormat::Xyz},
      {"0.5,1,2,255\n", FileFormat::Xyz},
      // By the names of their columns.
      {"X,Y,Z\n1,2,3\n", FileFormat::Xyz},
      {"\"X\";\"Y\";\"Z\"\n", FileFormat::Xyz},
      {"@File_Version: 4\n1 2 3\n", FileFormat::Xyz},
      {"", {}},
      {"\n\n", {}},
      {"# only a comment\n", {}},
      {"hello world\n", {}},
      {"1 2\n", {}},
      {"PK\x03", {}}};
  for (const auto& [content, format] : files) EXPECT_EQ(sniff(content), format) << content;
}

TEST(SniffFormat, KnowsTextOfAnyEncoding) {
  for (const std::string& wide : test::as_utf16("# made by hand\nsolid a\n"))
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

TEST(SniffFormat, KnowsWhatStandsInThePlaceOfAFile) {
  for (const auto& [content, told] : std::vector<std::pair<std::string, std::string>>{
           {"\x1f\x8b\x08", "gunzip"},
           {"PK\x03\x04", "unzip"},
           {"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"},
           {"<!DOCTYPE html><html>", "web page"}})
    EXPECT_THAT(std::string(foreign_content(test::bytes_of(content))), HasSubstr(told));
  for (const char* content : {"v 0 0 0\n", ""})
    EXPECT_EQ(foreign_content(test::bytes_of(content)), "");
}

// Files that an input names: read only where they may lie, never waited for, never without an end.

namespace fs = std::filesystem;
double peak_megabytes() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_maxrss) / 1024;
}

class NamedFiles : public testing::Test {
 protected:
  NamedFiles() { fs::create_directories(own_ / "sub"); }

  fs::path write(const fs::path& path, const std::string& text) const {
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  [[nodiscard]] std::string trouble(const fs::path& path,
                                    FileReach reach = FileReach::Beside) const {
    const NamedFile found = read_named(path, own_ / "a.obj", reach);
    if (!found.trouble.empty()) {
      EXPECT_TRUE(found.bytes.empty());
    }
    return found.trouble;
  }
  [[nodiscard]] FileMaterials materials(FileReach reach = FileReach::Beside) const {
    return read_materials({.bytes = {}, .name = "a.obj", .path = own_ / "a.obj", .reach = reach},
                          FileFormat::Obj, true, true);
  }
  // All that is no file, by its name in own_.
  [[nodiscard]] std::vector<std::string> put_what_is_no_file() const {
    EXPECT_EQ(mkfifo((own_ / "fifo").c_str(), 0600), 0);
    fs::create_symlink("/dev/zero", own_ / "zero");
    fs::create_symlink("fifo", own_ / "link");
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = (own_ / "socket").string();
    EXPECT_LT(name.size(), sizeof address.sun_path);
    std::strcpy(address.sun_path, name.c_str());
    const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ::close(socket);
    return {"fifo", "zero", "link", "socket", "sub"};
  }

  test::TemporaryFolder temporary_;
  fs::path own_ = temporary_.path() / "own";
  fs::path secret_ = write(temporary_.path() / "secret.png", test::AssetSample::image());
};

TEST_F(NamedFiles, AreReadAsTheyAre) {
  write(own_ / "a.mtl", "newmtl a\n");
  EXPECT_EQ(read_named(own_ / "a.mtl", own_ / "a.obj", FileReach::Beside).bytes.size(), 9u);
  const NamedFile start = read_named_start(own_ / "a.mtl", own_ / "a.obj", FileReach::Beside, 4);
  EXPECT_EQ(start.bytes.size(), 4u);
  EXPECT_EQ(start.size, 9u);
  write(own_ / "empty", "");
  EXPECT_EQ(trouble(own_ / "empty"), "");
  EXPECT_EQ(trouble(own_ / "none"),
            visible(own_ / "none") + ": cannot read: No such file or directory");
}

TEST_F(NamedFiles, WhatIsNoFileIsRefusedAtOnce) {
  const double before = peak_megabytes();
  for (const std::string& name : put_what_is_no_file()) {
    EXPECT_THAT(trouble(own_ / name, FileReach::Anywhere),
                HasSubstr(name + ": is a pipe, a device or a folder, where a file is wanted"));
  }
  fs::create_symlink("round", own_ / "about");
  fs::create_symlink("about", own_ / "round");
  EXPECT_THAT(trouble(own_ / "about", FileReach::Anywhere),
              HasSubstr("about: cannot read: Too many levels of symbolic links"));
  EXPECT_LT(peak_megabytes() - before, 20);
}

TEST_F(NamedFiles, OneThatNeverStopsGrowingIsReadAsItWas) {
  write(own_ / "log", std::string(1000, 'x'));
  std::atomic<bool> ends = false;
  std::thread writer([&] {
    std::ofstream log(own_ / "log", std::ios::app);
    const std::string more(1 << 16, 'y');
    for (int i = 0; i < 4000 && !ends; ++i) log << more << std::flush;
  });
  std::uint64_t last = 0;
  for (int i = 0; i < 50; ++i) {
    const NamedFile found = read_named(own_ / "log", own_ / "a.obj", FileReach::Beside);
    EXPECT_EQ(found.bytes.size(), found.size);
    EXPECT_GE(found.size, last);
    last = found.size;
    EXPECT_GE(read_file(own_ / "log").size(), last);
  }
  ends = true;
  writer.join();
}

TEST_F(NamedFiles, OneThatIsTooLongIsNotRead) {
  const double before = peak_megabytes();
  write(own_ / "long.png", "");
  fs::resize_file(own_ / "long.png", kMostNamedBytes + 1);
  EXPECT_THAT(trouble(own_ / "long.png"), HasSubstr("has 1073741825 bytes, and no more than"));
  EXPECT_EQ(
      read_named_start(own_ / "long.png", own_ / "a.obj", FileReach::Beside, 100).bytes.size(),
      100u);
  // Bytes beyond those that are wanted take no memory.
  EXPECT_LT(peak_megabytes() - before, 100);
}

TEST_F(NamedFiles, LieBesideTheInputOrBelowOnceLinksAreResolved) {
  fs::create_symlink("../secret.png", own_ / "link.png");
  fs::create_symlink("..", own_ / "up");
  for (const fs::path& path : {own_ / "../secret.png", own_ / "sub/../../secret.png", secret_,
                               own_ / "link.png", own_ / "up/secret.png", own_ / "../none.png"}) {
    EXPECT_EQ(trouble(path), visible(path) +
                                 ": leads away from the folder of the file "
                                 "(--textures anywhere follows it there)");
  }
  for (const fs::path& path : {secret_, own_ / "link.png", own_ / "up/secret.png"})
    EXPECT_EQ(trouble(path, FileReach::Anywhere), "");
  write(own_ / "sub/b.png", "b");
  fs::create_symlink("sub/b.png", own_ / "inside.png");
  for (const fs::path& path :
       {own_ / "sub/../sub/b.png", own_ / "inside.png", fs::absolute(own_) / "sub/b.png"})
    EXPECT_EQ(trouble(path), "");
  // A folder whose name goes on as ours does is another one.
  fs::create_directories(temporary_.path() / "own2");
  write(temporary_.path() / "own2/c.png", "c");
  EXPECT_THAT(trouble(own_ / "../own2/c.png"), HasSubstr("leads away"));
  // The input of another place, called here by a link: what lies beside either.
  fs::create_directories(temporary_.path() / "called");
  write(own_ / "a.obj", "");
  fs::create_symlink(own_ / "a.obj", temporary_.path() / "called/a.obj");
  fs::create_symlink(own_ / "sub/b.png", temporary_.path() / "called/b.png");
  EXPECT_EQ(read_named(temporary_.path() / "called/b.png", temporary_.path() / "called/a.obj",
                       FileReach::Beside)
                .trouble,
            "");
}

// By the readers.

TEST_F(NamedFiles, OfAnObjAreWarnedOfAndLeftOut) {
  const double before = peak_megabytes();
  std::vector<std::string> bad = put_what_is_no_file();
  bad.emplace_back("../secret.png");
  const std::string cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (const std::string& name : bad) {
    SCOPED_TRACE(name);
    write(own_ / "a.obj", "mtllib a.mtl\n" + cube);
    write(own_ / "a.mtl", "newmtl a\nKd 1 0 0\nmap_Kd " + name + "\n");
    const FileMaterials made = materials();
    EXPECT_THAT(made.gltf.images, IsEmpty());
    ASSERT_THAT(test::codes_of(made.warnings()), ElementsAre("left-out-textures"));
    EXPECT_THAT(made.warnings()[0].message,
                AllOf(HasSubstr(name + ": "), HasSubstr("; the texture is left out"),
                      HasSubstr(name.starts_with("..") ? "--textures anywhere" : "")));
    write(own_ / "a.obj", "mtllib " + name + "\n" + cube);
    const FileMaterials none = materials();
    ASSERT_THAT(test::codes_of(none.warnings()), ElementsAre("missing-materials"));
    EXPECT_THAT(none.warnings()[0].message, HasSubstr(name + ": "));
  }
  EXPECT_LT(peak_megabytes() - before, 30);
  // Whoever wants it gets it.
  write(own_ / "a.obj", "mtllib a.mtl\n" + cube);
  write(own_ / "a.mtl", "newmtl a\nmap_Kd ../secret.png\n");
  const FileMaterials anywhere = materials(FileReach::Anywhere);
  EXPECT_THAT(anywhere.warnings(), IsEmpty());
  ASSERT_EQ(anywhere.gltf.images.size(), 1u);
  EXPECT_EQ(anywhere.gltf.images[0].bytes.size(), test::AssetSample::image().size());
}

TEST_F(NamedFiles, OfAGltfAreErrorsWhereThereIsNoShapeWithoutThem) {
  const double before = peak_megabytes();
  const auto with_buffer = [&](const std::string& uri) {
    return write(own_ / "a.gltf", test::replaced(test::square_json(), R"([{"byteLength":60}])",
                                                 R"([{"byteLength":60,"uri":")" + uri + "\"}]"));
  };
  for (const std::string& name : put_what_is_no_file()) {
    const fs::path path = with_buffer(name);
    EXPECT_THAT(test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_mesh(path); }),
                AllOf(HasSubstr("buffers[0].uri: "), HasSubstr("own/" + name + ": "),
                      HasSubstr("; it belongs to this file, copy it along")));
  }
  // Of a file as long as it likes the bytes that the document speaks of.
  const fs::path long_file = write(temporary_.path() / "b.bin", test::square_chunk());
  fs::resize_file(long_file, std::uintmax_t{1} << 33);
  fs::create_symlink("../b.bin", own_ / "link.bin");
  for (const std::string& uri :
       {std::string("link.bin"), std::string("../b.bin"), long_file.string()}) {
    const fs::path path = with_buffer(uri);
    EXPECT_THAT(test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_mesh(path); }),
                AllOf(HasSubstr("leads away from the folder of the file"),
                      HasSubstr("--textures anywhere")));
    EXPECT_EQ(read_mesh(path, {.reach = FileReach::Anywhere}).mesh.face_count(), 2) << uri;
  }
  EXPECT_LT(peak_megabytes() - before, 60);
}

TEST_F(NamedFiles, AreKnownBeforeAnythingIsWrittenOverThem) {
  write(own_ / "a.obj", "mtllib a.mtl\nf 1 2 3\n");
  write(own_ / "a.mtl", "newmtl a\nmap_Kd -s 1 1 1 sub/wood.png\n");
  write(own_ / "sub/wood.png", "wood");
  write(own_ / "c.gltf", R"({"buffers": [{"uri": "c%20d.bin"}, {"uri": "data:,x"}],
                             "images": [{"uri": "sub/wood.png"}, 3],
                             "extensions": {"X": {"sounds": [{"uri": "e.wav"}]}}})");
  for (const char* name : {"c d.bin", "e.wav", "free.bin"}) write(own_ / name, name);
  InputFiles inputs;
  inputs.add(own_ / "a.obj");
  inputs.add(own_ / "c.gltf");
  fs::create_hard_link(own_ / "c d.bin", own_ / "hard.bin");
  fs::create_symlink("sub/wood.png", own_ / "soft.png");
  for (const char* name : {"a.mtl", "sub/wood.png", "c d.bin", "e.wav", "hard.bin", "soft.png"})
    EXPECT_THAT(inputs.objection(own_ / name), HasSubstr(" is read with the input ")) << name;
  EXPECT_THAT(inputs.objection(own_ / "sub/../a.obj"), HasSubstr("is the input itself"));
  // As a file system that folds case has it: another name of the same file.
  fs::create_hard_link(own_ / "a.obj", own_ / "A.OBJ");
  EXPECT_EQ(inputs.objection(own_ / "A.OBJ"), visible(own_ / "A.OBJ") + " is the input itself, " +
                                                  visible(own_ / "a.obj") +
                                                  "; choose another name");
  EXPECT_EQ(inputs.objection(own_ / "free.bin"), "");
  EXPECT_EQ(inputs.objection(own_ / "none.bin"), "");
  EXPECT_EQ(inputs.objection(own_ / "free.gltf", FileFormat::Gltf), "");
  EXPECT_THAT(inputs.objection(own_ / "hard.gltf", FileFormat::Gltf),
              HasSubstr("hard.gltf has a file beside it: "));
  fs::rename(own_ / "hard.bin", own_ / "x-3.bin");
  EXPECT_THAT(inputs.objection(own_ / "x.gltf", FileFormat::Gltf),
              HasSubstr("x-3.bin is read with the input "));
  EXPECT_THAT(inputs.objection_in(own_ / "sub"), HasSubstr("wood.png is read with the input"));
  EXPECT_EQ(inputs.objection_in(temporary_.path() / "none"), "");
}

TEST(ReadFile, ADeviceThatDoesNotEndIsNoInput) {
  const double before = peak_megabytes();
  EXPECT_THAT(test::message_of(ErrorCode::UnreadableInput, [] { (void)read_file("/dev/zero"); }),
              StartsWith("/dev/zero: is a device, and does not end after"));
  EXPECT_LT(peak_megabytes() - before, 300);
}

TEST(ReadFile, APipeIsReadToItsEnd) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  std::thread writer([&] {
    const std::string text(5'000'000, 'x');
    std::size_t at = 0;
    while (at < text.size())
      at += static_cast<std::size_t>(::write(ends[1], &text[at], text.size() - at));
    ::close(ends[1]);
  });
  EXPECT_EQ(read_stream(ends[0], "stdin").size(), 5'000'000u);
  writer.join();
  ::close(ends[0]);
}

}  // namespace
}  // namespace planish
