#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/read_file.h"
#include "planish/files/readers.h"
#include "support/calls.h"

namespace planish::test {

/// A file in memory; `bytes` must live longer.
[[nodiscard]] inline FileBytes file_of(std::string_view bytes, std::string_view name,
                                       bool is_strict = false) {
  return {.bytes = bytes_of(bytes), .name = name, .path = {}, .is_strict = is_strict};
}

inline std::string content_of(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline std::vector<std::string> codes_of(const std::vector<Warning>& warnings) {
  std::vector<std::string> codes;
  for (const Warning& warning : warnings) codes.push_back(warning.code);
  return codes;
}
inline std::vector<std::string> messages_of(const std::vector<Warning>& warnings) {
  std::vector<std::string> messages;
  for (const Warning& warning : warnings) messages.push_back(warning.message);
  return messages;
}

/// ASCII as UTF-16 of both byte orders, with and without the mark of theirs.
inline std::vector<std::string> as_utf16(const std::string& text) {
  std::string little, big;
  for (const char c : text) {
    little += {c, '\0'};
    big += {'\0', c};
  }
  return {"\xFF\xFE" + little, "\xFE\xFF" + big, little, big};
}

/// A file that a reader refuses, and what the error says behind the file's name and a colon.
struct WrongFile {
  std::string text;
  testing::Matcher<std::string> message;
};

/// By the reader that the extension of `name` says.
inline void expect_refused(std::string_view name, const std::vector<WrongFile>& files,
                           bool is_strict = false) {
  const FormatInfo& format = info_of(format_of(name).value());
  const std::string start = std::string(name) + ":";
  for (const WrongFile& file : files) {
    SCOPED_TRACE(file.text.substr(0, 200));
    const std::string message = message_of(ErrorCode::UnreadableInput, [&] {
      if (format.read_mesh) {
        (void)format.read_mesh(file_of(file.text, name, is_strict));
      } else {
        (void)format.read_points(file_of(file.text, name, is_strict));
      }
    });
    EXPECT_TRUE(message.starts_with(start)) << message;
    EXPECT_THAT(message.substr(std::min(start.size(), message.size())), file.message);
  }
}

inline MeshFile read_glb(const std::string& bytes) {
  return read_mesh(bytes_of(bytes), "a.glb", FileFormat::Glb);
}

/// The message that these bytes are refused with.
inline std::string glb_error(const std::string& bytes) {
  return message_of(ErrorCode::UnreadableInput, [&] { (void)read_glb(bytes); });
}

/// The square of glb_bytes.h with one change of its JSON.
inline std::string changed_square(const std::string& from, const std::string& to) {
  return glb_of(replaced(square_json(), from, to), square_chunk());
}
inline MeshFile read_square(const std::string& from, const std::string& to) {
  return read_glb(changed_square(from, to));
}

/// A change of JSON with which a reader refuses a file, and what the error says behind its name.
struct WrongJson {
  std::string from, to;
  testing::Matcher<std::string> message;
};

/// The square of glb_bytes.h, changed.
inline void expect_squares_refused(const std::vector<WrongJson>& changes) {
  std::vector<WrongFile> files;
  for (const auto& [from, to, message] : changes)
    files.push_back({changed_square(from, to), message});
  expect_refused("a.glb", files);
}

}  // namespace planish::test
