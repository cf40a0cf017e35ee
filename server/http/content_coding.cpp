#include "server/http/content_coding.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <charconv>
#include <climits>
#include <new>

#include "server/http/ascii.h"

namespace sightline {
namespace {

constexpr std::size_t kDecodedPiece = 64 << 10;
/// 8 MiB: what levels up to 19 use. A larger history would be memory that a client asks for.
constexpr int kLargestWindow = 23;
/// 16 more than the bits of a history of 32 KiB: with a gzip header.
constexpr int kGzipWindow = 15 + 16;
constexpr int kGzipLevel = 1, kZstdLevel = 1;

/// The part before `separator`; `text` becomes what is behind it.
std::string_view cut(std::string_view& text, char separator) {
  const std::size_t at = std::min(text.find(separator), text.size());
  const std::string_view part = text.substr(0, at);
  text.remove_prefix(std::min(at + 1, text.size()));
  return trimmed(part);
}

/// Of ";q=0.5"; what is none is 0.
double weight_of(std::string_view parameters) {
  double weight = 1;
  while (!parameters.empty()) {
    std::string_view value = cut(parameters, ';');
    if (value.size() < 2 || lower_case(value[0]) != 'q' || value[1] != '=') continue;
    value.remove_prefix(2);
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), weight);
    if (error != std::errc() || end != value.data() + value.size()) return 0;
  }
  return weight > 0 && weight <= 1 ? weight : 0;
}

uInt some(std::size_t count) {
  return static_cast<uInt>(std::min<std::size_t>(count, UINT_MAX / 2));
}

}  // namespace

std::string_view coding_name(Coding coding) {
  return coding == Coding::kGzip ? "gzip" : coding == Coding::kZstd ? "zstd" : "";
}

std::optional<Coding> find_coding(std::string_view name) {
  name = trimmed(name);
  if (name.empty() || equals_caseless(name, "identity")) return Coding::kIdentity;
  if (equals_caseless(name, "gzip") || equals_caseless(name, "x-gzip")) return Coding::kGzip;
  if (equals_caseless(name, "zstd")) return Coding::kZstd;
  return std::nullopt;
}

Coding choose_coding(std::string_view accept) {
  std::optional<double> gzip, zstd;
  double others = 0, plain = 0;
  while (!accept.empty()) {
    std::string_view parameters = cut(accept, ',');
    const std::string_view name = cut(parameters, ';');
    const double weight = weight_of(parameters);
    if (name == "*") others = weight;
    if (equals_caseless(name, "gzip") || equals_caseless(name, "x-gzip")) gzip = weight;
    if (equals_caseless(name, "zstd")) zstd = weight;
    if (equals_caseless(name, "identity")) plain = weight;
  }
  const double of_gzip = gzip.value_or(others), of_zstd = zstd.value_or(others);
  if (std::max(of_gzip, of_zstd) < plain) return Coding::kIdentity;
  if (of_zstd > 0 && of_zstd >= of_gzip) return Coding::kZstd;
  return of_gzip > 0 ? Coding::kGzip : Coding::kIdentity;
}

struct ContentDecoder::State {
  z_stream gzip{};
  ZSTD_DCtx* zstd = nullptr;
  bool has_more = false;  ///< there is output that waits for room
};

ContentDecoder::ContentDecoder(Coding coding) : state_(std::make_unique<State>()) {
  piece_.resize(kDecodedPiece);
  if (coding == Coding::kGzip) {
    if (inflateInit2(&state_->gzip, kGzipWindow) != Z_OK) throw std::bad_alloc();
    return;
  }
  state_->zstd = ZSTD_createDCtx();
  if (state_->zstd == nullptr) throw std::bad_alloc();
  ZSTD_DCtx_setParameter(state_->zstd, ZSTD_d_windowLogMax, kLargestWindow);
}

ContentDecoder::~ContentDecoder() {
  if (state_->zstd == nullptr) {
    inflateEnd(&state_->gzip);
  } else {
    ZSTD_freeDCtx(state_->zstd);
  }
}

std::size_t ContentDecoder::bytes() const {
  // [zlib] inflate: 32 KiB and its tables.
  constexpr std::size_t kGzip = 48 << 10;
  return kDecodedPiece + (state_->zstd == nullptr ? kGzip : ZSTD_sizeof_DCtx(state_->zstd));
}

std::span<const char> ContentDecoder::decode(std::string_view& input) {
  if (broken_ || (input.empty() && !state_->has_more)) return {};
  return state_->zstd == nullptr ? decode_gzip(input) : decode_zstd(input);
}

std::span<const char> ContentDecoder::decode_gzip(std::string_view& input) {
  z_stream& stream = state_->gzip;
  stream.next_out = reinterpret_cast<Bytef*>(piece_.data());
  stream.avail_out = static_cast<uInt>(piece_.size());
  while (stream.avail_out > 0 && (!input.empty() || state_->has_more)) {
    // A gzip file may be several, one behind the other.
    if (whole_ && !input.empty() && inflateReset(&stream) != Z_OK) break;
    whole_ = false;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(input.data()));
    stream.avail_in = some(input.size());
    const std::size_t given = stream.avail_in;
    const int result = inflate(&stream, Z_NO_FLUSH);
    input.remove_prefix(given - stream.avail_in);
    whole_ = result == Z_STREAM_END;
    state_->has_more = !whole_ && stream.avail_out == 0;
    if (result == Z_BUF_ERROR) break;
    broken_ = result != Z_OK && result != Z_STREAM_END;
    if (broken_) return {};
  }
  return {piece_.data(), piece_.size() - stream.avail_out};
}

std::span<const char> ContentDecoder::decode_zstd(std::string_view& input) {
  ZSTD_outBuffer out{piece_.data(), piece_.size(), 0};
  while (out.pos < out.size && (!input.empty() || state_->has_more)) {
    ZSTD_inBuffer in{input.data(), input.size(), 0};
    const std::size_t before = out.pos;
    const std::size_t result = ZSTD_decompressStream(state_->zstd, &out, &in);
    input.remove_prefix(in.pos);
    broken_ = ZSTD_isError(result) != 0;
    if (broken_) return {};
    whole_ = result == 0;
    state_->has_more = !whole_ && out.pos == out.size;
    if (in.pos == 0 && out.pos == before) break;
  }
  return {piece_.data(), out.pos};
}

struct ContentEncoder::State {
  z_stream gzip{};
  ZSTD_CCtx* zstd = nullptr;
};

ContentEncoder::ContentEncoder(Coding coding) : state_(std::make_unique<State>()) {
  if (coding == Coding::kGzip) {
    if (deflateInit2(&state_->gzip, kGzipLevel, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY) !=
        Z_OK) {
      throw std::bad_alloc();
    }
    return;
  }
  state_->zstd = ZSTD_createCCtx();
  if (state_->zstd == nullptr) throw std::bad_alloc();
  ZSTD_CCtx_setParameter(state_->zstd, ZSTD_c_compressionLevel, kZstdLevel);
}

ContentEncoder::~ContentEncoder() {
  if (state_->zstd == nullptr) {
    deflateEnd(&state_->gzip);
  } else {
    ZSTD_freeCCtx(state_->zstd);
  }
}

std::string ContentEncoder::encode(std::string_view text, bool is_last) {
  std::string out;
  std::size_t size = 0;
  const auto make_room = [&] { out.resize(std::max(out.size() * 2, text.size() / 4 + 256)); };
  if (state_->zstd != nullptr) {
    ZSTD_inBuffer in{text.data(), text.size(), 0};
    for (std::size_t left = 1; left != 0;) {
      if (size == out.size()) make_room();
      ZSTD_outBuffer to{out.data(), out.size(), size};
      left = ZSTD_compressStream2(state_->zstd, &to, &in, is_last ? ZSTD_e_end : ZSTD_e_flush);
      if (ZSTD_isError(left) != 0) throw std::bad_alloc();
      size = to.pos;
    }
    out.resize(size);
    return out;
  }
  z_stream& stream = state_->gzip;
  for (bool done = false; !done;) {
    if (size == out.size()) make_room();
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = some(text.size());
    const std::size_t given = stream.avail_in;
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + size);
    stream.avail_out = some(out.size() - size);
    const std::size_t room = stream.avail_out;
    const bool has_all = given == text.size();
    deflate(&stream, !has_all ? Z_NO_FLUSH : is_last ? Z_FINISH : Z_SYNC_FLUSH);
    text.remove_prefix(given - stream.avail_in);
    size += room - stream.avail_out;
    // What has not filled its room has nothing left to say.
    done = has_all && text.empty() && stream.avail_out > 0;
  }
  out.resize(size);
  return out;
}

}  // namespace sightline
