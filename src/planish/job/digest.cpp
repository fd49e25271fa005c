#include "planish/job/digest.h"

#ifdef PLANISH_PLAIN_SHA256
#include "planish/job/plain_sha256.h"
#else
#include <openssl/evp.h>
#endif

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <new>
#include <vector>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/core/stop.h"
#include "planish/core/visible_text.h"

namespace planish {
namespace {

std::string hexadecimal(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace

#ifdef PLANISH_PLAIN_SHA256
struct Sha256::Context {
  PlainSha256 state;
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {}

void Sha256::add(std::span<const std::byte> bytes) { context_->state.add(bytes); }

std::array<std::uint8_t, 32> Sha256::finish_bytes() { return context_->state.finish(); }
#else
struct Sha256::Context {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> state{EVP_MD_CTX_new(), EVP_MD_CTX_free};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  if (!context_->state) throw std::bad_alloc();
  PLANISH_ASSERT(EVP_DigestInit_ex(context_->state.get(), EVP_sha256(), nullptr) == 1);
}

void Sha256::add(std::span<const std::byte> bytes) {
  PLANISH_ASSERT(EVP_DigestUpdate(context_->state.get(), bytes.data(), bytes.size()) == 1);
}

std::array<std::uint8_t, 32> Sha256::finish_bytes() {
  std::array<std::uint8_t, 32> digest{};
  PLANISH_ASSERT(EVP_DigestFinal_ex(context_->state.get(), digest.data(), nullptr) == 1);
  return digest;
}
#endif

Sha256::~Sha256() = default;

std::string Sha256::finish() { return hexadecimal(finish_bytes()); }

std::array<std::uint8_t, 32> sha256_bytes(std::span<const std::byte> bytes) {
  constexpr std::size_t kPiece = 1 << 20;  // between looks at interrupts
  Sha256 digest;
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(kPiece, bytes.size()))) {
    check_stop();
    digest.add(bytes.first(std::min(kPiece, bytes.size())));
  }
  return digest.finish_bytes();
}

std::string sha256(std::span<const std::byte> bytes) { return hexadecimal(sha256_bytes(bytes)); }

// By no stream: those of C++ are a thirtieth of the WebAssembly library.
FileDigest digest_of(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  Sha256 digest;
  FileDigest result;
  std::vector<std::byte> buffer(1 << 20);
  while (file != nullptr && std::feof(file.get()) == 0 && std::ferror(file.get()) == 0) {
    check_stop();
    const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), file.get());
    digest.add(std::span(buffer).first(count));
    result.bytes += count;
  }
  if (file == nullptr || std::ferror(file.get()) != 0)
    throw Error(ErrorCode::UnreadableInput, visible(path) + ": cannot be read back");
  result.sha256 = digest.finish();
  return result;
}

}  // namespace planish
