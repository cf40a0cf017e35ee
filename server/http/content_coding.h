#pragma once
/// Compresses and decompresses bodies with gzip and zstd, piece by piece.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// A content coding [RFC9110] 8.4.1.
enum class Coding { kIdentity, kGzip, kZstd };

/// "gzip" or "zstd"; empty for identity.
std::string_view coding_name(Coding coding);
/// The coding that a Content-Encoding names, in any case: gzip, x-gzip, zstd or identity. Identity
/// if `name` is empty. No value for an unknown coding, and for several codings.
std::optional<Coding> find_coding(std::string_view name);
/// The coding that an Accept-Encoding prefers by its weights; of equal ones zstd, then gzip. "*"
/// counts for a coding that is not named. Identity if the text allows neither, or prefers identity.
Coding choose_coding(std::string_view accept);

/// Decodes a body in pieces of at most 64 KiB, so that a decompression bomb needs no more memory.
/// Call decode() until it returns nothing, then append more input. Not thread-safe.
class ContentDecoder {
 public:
  /// Precondition: `coding` is not identity. Throws std::bad_alloc.
  explicit ContentDecoder(Coding coding);
  ~ContentDecoder();
  ContentDecoder(const ContentDecoder&) = delete;
  ContentDecoder& operator=(const ContentDecoder&) = delete;

  /// Decodes the beginning of `input`, removes what it has read from `input`, and returns the
  /// decoded piece, which is valid until the next call. Empty if more input is needed, or if
  /// is_broken().
  std::span<const char> decode(std::string_view& input);
  /// Bytes of memory that the decoder uses. More after the first bytes of the body, which state the
  /// size of the history.
  std::size_t bytes() const;
  /// True if the input does not have this coding, or needs a history of more than 8 MiB.
  bool is_broken() const { return broken_; }
  /// True if the body may end here. Also true before the first byte.
  bool is_whole() const { return whole_; }

 private:
  struct State;
  std::span<const char> decode_gzip(std::string_view& input);
  std::span<const char> decode_zstd(std::string_view& input);

  std::unique_ptr<State> state_;
  std::string piece_;
  bool broken_ = false;
  bool whole_ = true;
};

/// Encodes an answer at the fastest level of its coding. Not thread-safe.
class ContentEncoder {
 public:
  /// Precondition: `coding` is not identity. Throws std::bad_alloc.
  explicit ContentEncoder(Coding coding);
  ~ContentEncoder();
  ContentEncoder(const ContentEncoder&) = delete;
  ContentEncoder& operator=(const ContentEncoder&) = delete;

  /// Returns the next part of the encoded answer. All of `text` can be decoded from what was
  /// returned so far. No call may follow after `is_last`. Throws std::bad_alloc.
  std::string encode(std::string_view text, bool is_last);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sightline
