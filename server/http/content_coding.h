#pragma once
/// Compressed bodies: gzip and zstd, both ways, piece by piece.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

enum class Coding { kIdentity, kGzip, kZstd };

/// "gzip", "zstd"; of identity nothing.
std::string_view coding_name(Coding coding);
/// What a Content-Encoding names; nothing is identity. Empty for what is not known here, and for
/// several of them.
std::optional<Coding> find_coding(std::string_view name);
/// What an Accept-Encoding likes best of those; of equals zstd, then gzip. Identity when it says
/// nothing of them.
Coding choose_coding(std::string_view accept);

/// Decodes a body in pieces of at most 64 KiB, however much a decompression bomb expands to.
class ContentDecoder {
 public:
  /// Precondition: not identity. Throws std::bad_alloc.
  explicit ContentDecoder(Coding coding);
  ~ContentDecoder();
  ContentDecoder(const ContentDecoder&) = delete;
  ContentDecoder& operator=(const ContentDecoder&) = delete;

  /// Decodes from `input` on, which shrinks by what was read, and returns the next piece; empty
  /// when more input is needed.
  std::span<const char> decode(std::string_view& input);
  /// Bytes of memory that it uses. They grow when the first bytes have stated the size of the
  /// history.
  std::size_t bytes() const;
  /// The input is not of this coding, or needs a history of more than 8 MiB.
  bool is_broken() const { return broken_; }
  /// Whether the body may end here.
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

/// Encodes an answer, quickly rather than small.
class ContentEncoder {
 public:
  /// Precondition: not identity. Throws std::bad_alloc.
  explicit ContentEncoder(Coding coding);
  ~ContentEncoder();
  ContentEncoder(const ContentEncoder&) = delete;
  ContentEncoder& operator=(const ContentEncoder&) = delete;

  /// The next part of the answer. All of `text` can be decoded from what was returned so far;
  /// nothing may follow after `is_last`.
  std::string encode(std::string_view text, bool is_last);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sightline
