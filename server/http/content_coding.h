#pragma once
/// Compresses and decompresses bodies with gzip and zstd, piece by piece.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

enum class Coding { kIdentity, kGzip, kZstd };

/// "gzip" or "zstd"; empty for identity.
std::string_view coding_name(Coding coding);
/// The coding that a Content-Encoding names; identity if `name` is empty. No value for an unknown
/// coding, and for several codings.
std::optional<Coding> find_coding(std::string_view name);
/// The coding that an Accept-Encoding prefers; of equal ones zstd, then gzip. Identity if it names
/// neither.
Coding choose_coding(std::string_view accept);

/// Decodes a body in pieces of at most 64 KiB, however large a decompression bomb is.
class ContentDecoder {
 public:
  /// Precondition: not identity. Throws std::bad_alloc.
  explicit ContentDecoder(Coding coding);
  ~ContentDecoder();
  ContentDecoder(const ContentDecoder&) = delete;
  ContentDecoder& operator=(const ContentDecoder&) = delete;

  /// Decodes the beginning of `input`, removes it from `input`, and returns the decoded piece;
  /// empty if more input is needed.
  std::span<const char> decode(std::string_view& input);
  /// The memory that the decoder uses. It grows when the first bytes have stated the size of the
  /// history.
  std::size_t bytes() const;
  /// True if the input does not have this coding, or needs a history of more than 8 MiB.
  bool is_broken() const { return broken_; }
  /// True if the body may end here.
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

/// Encodes an answer; it is fast rather than small.
class ContentEncoder {
 public:
  /// Precondition: not identity. Throws std::bad_alloc.
  explicit ContentEncoder(Coding coding);
  ~ContentEncoder();
  ContentEncoder(const ContentEncoder&) = delete;
  ContentEncoder& operator=(const ContentEncoder&) = delete;

  /// Returns the next part of the encoded answer. All of `text` can be decoded from what was
  /// returned so far. No call may follow after `is_last`.
  std::string encode(std::string_view text, bool is_last);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sightline
