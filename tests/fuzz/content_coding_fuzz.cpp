// Compressed bodies: pieces of at most 64 KiB, the same ones however the body was cut; and what is
// encoded is decoded again.
// Run:  scripts/stress.sh fuzz --target content_coding_fuzz
//
// The first byte of an input says which coding it is and how it is cut.

#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/content_coding.h"
#include "tests/fuzz/cuts.h"
#include "tests/fuzz/promise.h"

using namespace sightline;

namespace {

using fuzz::require;

/// Whoever takes the pieces of a bomb stops somewhere.
constexpr std::size_t kEnough = 256 << 10, kLargestPiece = 64 << 10;

struct Decoded {
  std::string text;
  bool broken = false, whole = false;
};

Decoded decode(Coding coding, std::string_view body, unsigned seed) {
  ContentDecoder decoder(coding);
  fuzz::Cuts cuts(seed);
  Decoded all;
  while (!body.empty() && !decoder.is_broken() && all.text.size() < kEnough) {
    std::string_view input = body.substr(0, cuts.next(body.size()));
    body.remove_prefix(input.size());
    for (;;) {
      const std::size_t before = input.size();
      const auto piece = decoder.decode(input);
      require(piece.size() <= kLargestPiece, "pieces are small");
      require(input.size() <= before, "input is taken");
      all.text.append(piece.data(), piece.size());
      if (piece.empty() || all.text.size() >= kEnough) break;
    }
    require(decoder.is_broken() || input.empty() || all.text.size() >= kEnough,
            "what was given is used");
  }
  all.broken = decoder.is_broken();
  all.whole = decoder.is_whole();
  return all;
}

void check_round_trip(Coding coding, std::string_view text, unsigned seed) {
  ContentEncoder encoder(coding);
  fuzz::Cuts cuts(seed);
  std::string coded;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t count = cuts.next(text.size() - at);
    coded += encoder.encode(text.substr(at, count), false);
    at += count;
    require(decode(coding, coded, 0).text == text.substr(0, at), "what was encoded is there");
  }
  coded += encoder.encode("", true);
  const Decoded again = decode(coding, coded, seed);
  require(!again.broken && again.whole && again.text == text, "an answer is decoded as it was");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Coding coding = data[0] % 2 == 0 ? Coding::kGzip : Coding::kZstd;
  const unsigned seed = data[0] / 2 + 1;
  const std::string_view body(reinterpret_cast<const char*>(data) + 1, size - 1);
  const Decoded whole = decode(coding, body, 0), parts = decode(coding, body, seed);
  if (whole.text.size() < kEnough && parts.text.size() < kEnough) {
    require(whole.broken == parts.broken, "pieces are judged alike");
    require(whole.broken || (whole.text == parts.text && whole.whole == parts.whole),
            "pieces are decoded alike");
  }
  if (size < 256) check_round_trip(coding, body, seed);
  if (const auto found = find_coding(body)) {
    require(*found == Coding::kIdentity || choose_coding(body) == *found, "a name is accepted");
  }
  static_cast<void>(choose_coding(body));
  return 0;
}
