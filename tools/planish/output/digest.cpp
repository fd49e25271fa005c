#include "output/digest.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <new>
#include <vector>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/core/stop.h"
#include "planish/core/visible_text.h"

namespace planish::command {
struct Sha256::Context {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> state{EVP_MD_CTX_new(), EVP_MD_CTX_free};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  if (!context_->state) throw std::bad_alloc();
  PLANISH_ASSERT(EVP_DigestInit_ex(context_->state.get(), EVP_sha256(), nullptr) == 1);
}

Sha256::~Sha256() = default;

void Sha256::add(std::span<const std::byte> bytes) {
  PLANISH_ASSERT(EVP_DigestUpdate(context_->state.get(), bytes.data(), bytes.size()) == 1);
}

std::string Sha256::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  PLANISH_ASSERT(EVP_DigestFinal_ex(context_->state.get(), digest.data(), &length) == 1);
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < length; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

std::string sha256(std::span<const std::byte> bytes) {
  constexpr std::size_t kPiece = 1 << 20;  // between looks at interrupts
  Sha256 digest;
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(kPiece, bytes.size()))) {
    check_stop();
    digest.add(bytes.first(std::min(kPiece, bytes.size())));
  }
  return digest.finish();
}

FileDigest digest_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  Sha256 digest;
  FileDigest result;
  std::vector<char> buffer(1 << 20);
  while (file) {
    check_stop();
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    digest.add(std::as_bytes(std::span(buffer).first(static_cast<std::size_t>(file.gcount()))));
    result.bytes += static_cast<std::uint64_t>(file.gcount());
  }
  if (!file.eof()) throw Error(ErrorCode::UnreadableInput, visible(path) + ": cannot be read back");
  result.sha256 = digest.finish();
  return result;
}

}  // namespace planish::command
