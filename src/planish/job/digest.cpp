#include "planish/job/digest.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <new>
#include <span>
#include <system_error>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/platform/files.h"
#include "planish/core/words.h"

#ifndef PLANISH_PLAIN_SHA256
#include <openssl/evp.h>
#endif

namespace planish {
namespace {

constexpr std::array<std::uint32_t, 64> kRoundConstants = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

}  // namespace

void PlainSha256::add_block(const std::byte* block) {
  std::array<std::uint32_t, 64> w{};
  for (std::size_t i = 0; i < 64; ++i)
    w[i / 4] = w[i / 4] << 8 | static_cast<std::uint32_t>(block[i]);
  for (std::size_t i = 16; i < 64; ++i) {
    const std::uint32_t a = w[i - 15], b = w[i - 2];
    w[i] = w[i - 16] + w[i - 7] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ a >> 3) +
           (std::rotr(b, 17) ^ std::rotr(b, 19) ^ b >> 10);
  }
  auto [a, b, c, d, e, f, g, h] = state_;
  for (std::size_t i = 0; i < 64; ++i) {
    const std::uint32_t t = h + (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) +
                            ((e & f) ^ (~e & g)) + kRoundConstants[i] + w[i];
    const std::uint32_t u =
        (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t;
    d = c, c = b, b = a, a = t + u;
  }
  const std::array<std::uint32_t, 8> added = {a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i) state_[i] += added[i];
}

void PlainSha256::add(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t held = length_ % 64;
    const std::size_t taken = std::min(64 - held, bytes.size());
    length_ += taken;
    if (taken == 64) {
      add_block(bytes.data());
    } else {
      std::copy_n(bytes.begin(), taken, rest_.begin() + static_cast<std::ptrdiff_t>(held));
      if (held + taken == 64) add_block(rest_.data());
    }
    bytes = bytes.subspan(taken);
  }
}

std::array<std::uint8_t, 32> PlainSha256::finish() {
  const std::uint64_t bits = 8 * length_;
  std::array<std::byte, 72> padding{std::byte{0x80}};
  const std::size_t zeros = (119 - length_ % 64) % 64;  // and the 0x80: 56 modulo 64
  for (std::size_t i = 0; i < 8; ++i)
    padding[1 + zeros + i] = static_cast<std::byte>(bits >> (56 - 8 * i));
  add(std::span(padding).first(1 + zeros + 8));
  std::array<std::uint8_t, 32> digest{};
  for (std::size_t i = 0; i < 32; ++i)
    digest[i] = static_cast<std::uint8_t>(state_[i / 4] >> (24 - 8 * (i % 4)));
  return digest;
}

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

FileDigest digest_of(const std::filesystem::path& path) {
  std::error_code error;
  const platform::File file = platform::open_to_read(path, error);
  Sha256 digest;
  FileDigest result;
  std::vector<std::byte> buffer(1 << 20);
  for (std::size_t count = 1; count > 0 && !error; result.bytes += count) {
    check_stop();
    count = platform::read_some(file.number(), buffer, error);
    digest.add(std::span(buffer).first(count));
  }
  if (error) throw Error(ErrorCode::UnreadableInput, visible(path) + ": cannot be read back");
  result.sha256 = digest.finish();
  return result;
}

}  // namespace planish
