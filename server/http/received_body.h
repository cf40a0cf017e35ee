#pragma once
/// What has come of a request body: the first bytes in memory, the rest in a temporary file.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/chunk_decoder.h"
#include "server/http/request_head.h"
#include "server/http/request_memory.h"
#include "server/http/spool.h"

namespace sightline {

/// Takes a body off what a connection receives, removes the chunk framing, and stores the payload
/// until it is read. One thread at a time.
class ReceivedBody {
 public:
  /// Bytes that stay in memory, and those of a body that is taken in parts.
  static constexpr std::size_t kInMemory = 4 << 10, kPart = 64 << 10;

  ReceivedBody(const RequestHead& head, MemoryBudget& budget, Spool& spool)
      : is_chunked_(head.chunked), left_(head.length.value_or(0)), budget_(budget), file_(spool) {}
  ~ReceivedBody() { budget_.release(charged_); }
  ReceivedBody(const ReceivedBody&) = delete;
  ReceivedBody& operator=(const ReceivedBody&) = delete;

  /// Takes bytes of this body off the front of `input`, which is overwritten. False where the spool
  /// has no room for them.
  bool take(char* input, std::size_t size, std::size_t& taken);
  /// The client ended its side.
  void end() { has_ended_ = true; }

  /// Whether the last byte has come.
  bool is_whole() const { return is_chunked_ ? chunks_.is_over() : left_ == 0; }
  /// Whether the rest cannot come: the client ended its side, or the chunks are malformed.
  bool is_broken() const { return chunks_.is_broken() || (has_ended_ && !is_whole()); }
  /// Payload bytes that have come, and how many of them were dropped.
  std::uint64_t size() const { return dropped_ + memory_.size() + file_.size(); }
  std::uint64_t dropped() const { return dropped_; }
  std::uint64_t unread() const { return memory_.size() + file_.size() - at_; }
  /// Bytes of the body that a client has yet to send. Precondition: the body is not chunked.
  std::uint64_t to_come() const { return left_; }
  bool is_chunked() const { return is_chunked_; }
  /// Bytes in the temporary file.
  std::uint64_t spooled() const { return file_.size(); }

  /// Reads at most `size` bytes from where the last read ended. Fewer where no more have come, or
  /// where the disk fails, which has_failed() tells.
  std::size_t read(char* data, std::size_t size);
  bool has_failed() const { return has_failed_; }
  /// Begins again with the first byte that was stored.
  void rewind() { at_ = 0; }
  /// What has come was read as a part, and goes; kPart bytes of the next part stay in memory where
  /// the budget has room. Precondition: unread() is 0, or nothing has come.
  void begin_part();

 private:
  bool store(std::string_view payload);

  const bool is_chunked_;
  std::uint64_t left_;
  ChunkDecoder chunks_;
  bool has_ended_ = false, has_failed_ = false, in_parts_ = false;
  MemoryBudget& budget_;
  std::uint64_t charged_ = 0;
  std::string memory_;
  SpoolFile file_;
  std::uint64_t at_ = 0, dropped_ = 0;
};

}  // namespace sightline
