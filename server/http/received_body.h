#pragma once
/// ReceivedBody: the part of a request body that has arrived. The first bytes are in memory, the
/// rest in a temporary file.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/chunk_decoder.h"
#include "server/http/request_head.h"
#include "server/http/request_memory.h"
#include "server/http/spool.h"

namespace sightline {

/// Takes the bytes that a connection receives, removes chunk framing, and stores the payload until
/// it is read. Not thread-safe.
class ReceivedBody {
 public:
  /// Bytes that are stored in memory: in any case; of each part of a body in parts, and of a whole
  /// body, as long as the budget has room. Further bytes are in the temporary file.
  static constexpr std::size_t kInMemory = 4 << 10, kPart = 64 << 10, kWhole = 1 << 20;
  /// Whole bodies are stored in memory while that and the like take at most this part of the budget:
  /// an eighth.
  static constexpr std::uint64_t kPartForWhole = 8;

  /// `budget` and `spool` must outlive the body; `head` is only read here.
  ReceivedBody(const RequestHead& head, MemoryBudget& budget, Spool& spool)
      : is_chunked_(head.chunked), left_(head.length.value_or(0)), budget_(budget), file_(spool) {}
  ~ReceivedBody() { budget_.release(charged_); }
  ReceivedBody(const ReceivedBody&) = delete;
  ReceivedBody& operator=(const ReceivedBody&) = delete;

  /// Takes bytes of this body from the front of `input`, whose memory is overwritten; sets `taken`
  /// to their number. Returns false if the spool has no room for them; the body is then incomplete,
  /// and its request must be refused.
  bool take(char* input, std::size_t size, std::size_t& taken);
  /// Records that the client has closed its side.
  void end() { has_ended_ = true; }

  /// True if the last byte has arrived.
  bool is_whole() const { return is_chunked_ ? chunks_.is_over() : left_ == 0; }
  /// True if the rest cannot arrive: the client has closed its side, or the chunks are malformed.
  bool is_broken() const { return chunks_.is_broken() || (has_ended_ && !is_whole()); }
  /// Payload bytes that have arrived, and those of them that were dropped after reading.
  std::uint64_t size() const { return dropped_ + memory_.size() + file_.size(); }
  std::uint64_t dropped() const { return dropped_; }
  /// Stored bytes that read() has not delivered.
  std::uint64_t unread() const { return memory_.size() + file_.size() - at_; }
  /// Bytes that the client has yet to send. Precondition: the body is not chunked.
  std::uint64_t to_come() const { return left_; }
  bool is_chunked() const { return is_chunked_; }
  /// Bytes in the temporary file.
  std::uint64_t spooled() const { return file_.size(); }

  /// Reads at most `size` bytes from where the last read ended. Returns fewer if no more have
  /// arrived, or if the disk fails, which has_failed() tells.
  std::size_t read(char* data, std::size_t size);
  bool has_failed() const { return has_failed_; }
  /// Lets the next read begin at the first stored byte.
  void rewind() { at_ = 0; }
  /// Drops what has arrived, after it was read as a part. kPart bytes of the next part are stored
  /// in memory if the budget has room. Precondition: unread() is 0, or nothing has arrived.
  void begin_part();

 private:
  bool store(std::string_view payload);
  /// How many bytes memory_ may have, of at most `wanted`. Charges the budget for them.
  std::size_t room_for(std::size_t wanted);

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
