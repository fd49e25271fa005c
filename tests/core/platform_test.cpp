#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <system_error>

#include "planish/core/platform/files.h"
#include "planish/core/platform/machine.h"
#include "planish/core/platform/process.h"
#include "planish/core/words.h"

namespace planish::platform {
namespace {

namespace fs = std::filesystem;

class PlatformFiles : public ::testing::Test {
 protected:
  PlatformFiles() {
    std::error_code error;
    folder_ = make_temporary_folder(fs::temp_directory_path(), error);
    EXPECT_FALSE(error) << error.message();
  }
  ~PlatformFiles() override { remove_folder(folder_); }

  fs::path make(const fs::path& name, const std::string& content = "abc") {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  static std::string content(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  fs::path folder_;
};

TEST_F(PlatformFiles, ReadsFromAnyPlace) {
  const fs::path path = make("a", "0123456789");
  std::error_code error;
  const File file = open_to_read(path, error);
  ASSERT_FALSE(error) << error.message();
  EXPECT_EQ(facts_of(file.number(), error).size, 10u);
  EXPECT_EQ(facts_of(file.number(), error).kind, FileKind::Regular);
  std::array<std::byte, 4> bytes{};
  EXPECT_EQ(read_at(file.number(), bytes, 5, error), 4u);
  EXPECT_EQ(std::memcmp(bytes.data(), "5678", 4), 0);
  EXPECT_EQ(read_at(file.number(), bytes, 8, error), 2u);
  EXPECT_EQ(read_at(file.number(), bytes, 10, error), 0u);
  EXPECT_FALSE(error) << error.message();
}

TEST_F(PlatformFiles, SaysWhyNothingIsOpened) {
  std::error_code error;
  EXPECT_FALSE(open_to_read(folder_ / "none", error).is_open());
  EXPECT_EQ(error, std::errc::no_such_file_or_directory);
  EXPECT_FALSE(create_new(folder_ / "none" / "a", error).is_open());
  EXPECT_EQ(error, std::errc::no_such_file_or_directory);
  EXPECT_FALSE(create_new(make("a"), error).is_open());
  EXPECT_EQ(error, std::errc::file_exists);
}

TEST_F(PlatformFiles, WritesBytesAsTheyAre) {
  std::error_code error;
  File file = create_new(folder_ / "a", error);
  ASSERT_FALSE(error) << error.message();
  const std::string text = "a\nb\r\nc\x1a";
  const bool has_room = reserve(file.number(), 1 << 20, error);
  EXPECT_FALSE(error) << error.message();
  EXPECT_FALSE(write_all(file.number(), std::as_bytes(std::span(text))));
  if (has_room) {
    EXPECT_FALSE(set_size(file.number(), text.size()));
  }
  EXPECT_FALSE(file.close());
  EXPECT_EQ(content(folder_ / "a"), text);
}

TEST_F(PlatformFiles, RefusesRoomThatNoDiskHas) {
  std::error_code error;
  const File file = create_new(folder_ / "a", error);
  if (reserve(file.number(), std::uint64_t{1} << 60, error)) FAIL() << "an exabyte is free";
#ifdef __linux__
  EXPECT_EQ(error, std::errc::no_space_on_device);
#endif
}

TEST_F(PlatformFiles, RenamesWhatIsOpen) {
  const fs::path from = make("from", "new");
  const fs::path to = make("to", "old");
  std::error_code error;
  const File reader = open_to_read(from, error);
  EXPECT_EQ(rename_file(from, to, false), std::errc::file_exists);
  EXPECT_EQ(content(to), "old");
  EXPECT_FALSE(rename_file(from, to, true));
  EXPECT_EQ(content(to), "new");
  EXPECT_FALSE(fs::exists(from));
}

TEST_F(PlatformFiles, RenamesFolders) {
  fs::create_directory(folder_ / "a");
  fs::create_directory(folder_ / "empty");
  fs::create_directory(folder_ / "full");
  make(fs::path("full") / "x");
  EXPECT_TRUE(rename_file(folder_ / "a", folder_ / "full", true));
  EXPECT_TRUE(fs::exists(folder_ / "full" / "x"));
  EXPECT_FALSE(rename_file(folder_ / "full", folder_ / "empty", true));
  EXPECT_TRUE(fs::exists(folder_ / "empty" / "x"));
}

TEST_F(PlatformFiles, OneFileHasOneIdentity) {
  const fs::path a = make("a"), b = make("b");
  std::error_code error;
  fs::create_hard_link(a, folder_ / "c", error);
  ASSERT_FALSE(error) << error.message();
  ASSERT_TRUE(identity_of(a));
  EXPECT_EQ(identity_of(a), identity_of(folder_ / "." / "c"));
  EXPECT_NE(identity_of(a), identity_of(b));
  EXPECT_FALSE(identity_of(folder_ / "none"));
  EXPECT_EQ(comparable(a) == comparable(folder_ / "A"), identity_of(folder_ / "A").has_value());
}

TEST_F(PlatformFiles, NamesOfAllLetters) {
  for (const char* const name : {"ä.obj", "Ω漢.obj", "👍.obj"}) {
    const fs::path path = folder_ / path_of(name);
    std::error_code error;
    (void)create_new(path, error);
    EXPECT_FALSE(error) << name << ": " << error.message();
    EXPECT_EQ(utf8(path.filename()), name);
    EXPECT_TRUE(fs::exists(path));
    EXPECT_EQ(visible(path.filename()), name);
  }
}

TEST_F(PlatformFiles, LongPaths) {
  fs::path deep = folder_;
  for (int i = 0; i < 4; ++i) deep /= std::string(100, static_cast<char>('a' + i));
  std::error_code error;
  fs::create_directories(deep, error);
  ASSERT_FALSE(error) << error.message();
  (void)create_new(deep / "a", error);
  EXPECT_FALSE(error) << error.message();
  EXPECT_FALSE(rename_file(deep / "a", deep / "b", false));
  EXPECT_TRUE(identity_of(deep / "b"));
  (void)open_to_read(deep / "b", error);
  EXPECT_FALSE(error) << error.message();
}

TEST(PlatformNames, SomeAreNone) {
  EXPECT_EQ(objection_to_name("folder/out.glb"), "");
  EXPECT_NE(objection_to_name(fs::path("folder") / std::string(256, 'a')), "");
#ifdef _WIN32
  for (const char* const name : {"con", "NUL.glb", "Com1.obj", "lpt9", "a.", "a ", "a?.glb", "a|b"})
    EXPECT_NE(objection_to_name(name), "") << name;
  for (const char* const name : {"conn", "com.glb", "a b.glb", ".a", ".."})
    EXPECT_EQ(objection_to_name(name), "") << name;
#endif
}

TEST_F(PlatformFiles, RemovesFoldersWithAllThatIsInThem) {
  fs::create_directories(folder_ / "a" / "b");
  make(fs::path("a") / "b" / "c");
  make(fs::path("a") / "d");
  remove_folder(folder_ / "a");
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  EXPECT_TRUE(fs::exists(folder_));
}

TEST_F(PlatformFiles, NamelessFilesLeaveNothing) {
  constexpr std::size_t kBytes = 1 << 20;
  std::error_code error;
  void* array = nullptr;
  {
    const File file = open_nameless(folder_, error);
    ASSERT_FALSE(error) << error.message();
    array = map_file(file.number(), kBytes, error);
    ASSERT_NE(array, nullptr) << error.message();
  }
  std::memset(array, 7, kBytes);
  let_pages_go(array, kBytes);
  EXPECT_EQ(static_cast<unsigned char*>(array)[kBytes - 1], 7);
  unmap(array, kBytes);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST(PlatformMachine, HasMemory) {
  EXPECT_GT(free_memory(), 1u << 20);
  EXPECT_GT(peak_memory(), 1u << 20);
  EXPECT_GT(resident_memory(), 1u << 20);
  void* const array = map_memory(1 << 20);
  ASSERT_NE(array, nullptr);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array) % kLeastPage, 0u);
  std::memset(array, 1, 1 << 20);
  unmap(array, 1 << 20);
  EXPECT_NE(host_name(), "");
}

TEST(PlatformMachine, CountsTheTimeThatIsWorked) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(60);
  const std::int64_t before = thread_nanoseconds();
  while (std::chrono::steady_clock::now() < until) {
  }
  const std::int64_t after = thread_nanoseconds();
  EXPECT_GT(after, before);
  EXPECT_GE(process_nanoseconds(), after);
}

TEST(PlatformProcess, KnowsItself) {
  const auto program = own_program();
  ASSERT_TRUE(program);
  EXPECT_TRUE(is_program(*program));
  EXPECT_FALSE(is_program(program->parent_path()));
  EXPECT_EQ(program_in(program->parent_path(), utf8(program->stem())), *program);
  EXPECT_FALSE(program_folders().empty());
}

TEST_F(PlatformFiles, NoFileIsATerminal) {
  std::error_code error;
  const File file = open_to_read(make("a"), error);
  EXPECT_FALSE(is_terminal(file.number()));
  EXPECT_FALSE(moves_cursor(file.number()));
  EXPECT_FALSE(terminal_columns(file.number()));
}

TEST_F(PlatformFiles, NoProgramIsStartedThatIsNone) {
  ChildProcess child;
  EXPECT_TRUE(child.start(folder_ / "none"));
}

TEST(PlatformProcess, LibrariesAreNamed) {
  std::string why;
  EXPECT_EQ(load_library(library_file("no-such", 3), why), nullptr);
  EXPECT_NE(why, "");
}

}  // namespace
}  // namespace planish::platform
