#pragma once
/// BodyReader: reads the body of a request for its handler.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "server/http/connection.h"
#include "server/http/content_coding.h"
#include "server/http/pace.h"
#include "server/http/request_memory.h"

namespace sightline {

class ResponseWriter;

/// The body of one request, during one call of its handler. The handler reads it by read() or
/// read_all(); HttpServer calls finish() afterwards. Not thread-safe.
///
/// Only the thread of a stream waits for its client. For other requests the event loop receives the
/// body. A handler that needs more of it calls ask_for() or ask_for_next_part(). If that puts the
/// request off, the handler returns without an answer, and is called again when more has arrived.
class BodyReader {
 public:
  /// Why the body cannot be read to its end.
  enum class Fault {
    kNoFault,
    kEnded,   ///< the client stopped sending, or the chunks are malformed
    kSlow,    ///< the client sends too slowly
    kCoding,  ///< the body does not have its Content-Encoding, or ends too early
    /// there is no memory for the decoder now, or other requests wait for the memory of this one
    kMemory,
    kDisk,  ///< the temporary file of the body cannot be read
  };
  /// `connection`, `writer` and `memory` must outlive the reader; `pace` is copied.
  /// busy_rate  bytes per second: the least rate of a stream while other requests wait for memory
  /// memory     counts the memory of a decoder, whose size the client determines
  BodyReader(Connection& connection, ResponseWriter& writer, const PaceLimits& pace,
             std::uint64_t busy_rate, RequestMemory& memory);

  /// True if `bytes` bytes of the body as received, or all of it, can be read now. If false, the
  /// request is put off: the handler must return without an answer, and is called again when these
  /// bytes have arrived.
  bool ask_for(std::uint64_t bytes);
  /// True if the handler runs on a thread that may wait for the client. If false, the request is
  /// put off until such a thread is free.
  bool may_wait();
  /// True if a request of this cost may be answered on this thread: short ones on any thread, long
  /// ones on a worker for long requests. If false, the request is put off until such a worker is
  /// free.
  /// cost  in rays of an ordinary query
  bool may_cost(std::uint64_t cost);
  /// True after one of these functions has put the request off.
  bool is_put_off() const { return connection_.put_off != Connection::PutOff::kNo; }
  /// State of a handler whose request is put off. While it is not null, the handler is called again
  /// for each part of the body, and parts that were read are not delivered again.
  std::shared_ptr<void>& kept() { return connection_.kept; }
  /// Bytes, before decoding, of the parts that earlier calls of the handler have read.
  std::uint64_t read_before() const { return connection_.body ? connection_.body->dropped() : 0; }
  /// Puts the request off until the next part has arrived. Precondition: all that has arrived was
  /// read.
  void ask_for_next_part();

  /// Sets the coding of the body; from then on pieces are decoded. No effect for identity. Throws
  /// std::bad_alloc.
  void decode_as(Coding coding);
  bool decodes() const { return decoder_ != nullptr; }
  /// Frees the decoder and releases its memory. Precondition: all of the body was read. The
  /// received bytes stay, because the request may begin again.
  void end_decoding() {
    decoder_.reset();
    memory_.unpin();
  }
  /// Restarts the time limit. A stream may last for any time, if the client sends at the least rate
  /// while the server reads.
  void restart_pace();
  /// Passes the body in pieces to `sink`. Returns true at the end of the body, and if no more has
  /// arrived. A stream waits for more, unless `wait` is false. Returns false if `sink` returns
  /// false, after which the next call continues, or after a fault: see fault(). A piece is valid
  /// during the call of `sink`.
  bool read(const std::function<bool(std::span<const char>)>& sink, bool wait = true);
  /// Appends the rest of the body to `text`, without an intermediate copy. Calls admit(bytes)
  /// before it appends so many bytes; admit may make room, and may refuse by returning false.
  /// Returns false after a refusal or a fault; `text` then has a part of the body.
  bool read_all(std::string& text, const std::function<bool(std::size_t bytes)>& admit);
  /// Bytes that read_all will append, if known.
  std::optional<std::uint64_t> unread_bytes() const;
  /// True if the end of the body has arrived; after a read() that returned true, all of it was
  /// passed on.
  bool is_over() const;
  /// Why read() or read_all() returned false; kNoFault if their callback did.
  Fault fault() const { return fault_; }
  /// True if this reader received a part of the body itself, on the thread of a stream.
  bool has_received() const { return has_received_; }
  /// True if the beginning of the next request is known, and near enough to read up to it.
  bool is_skippable() const;
  /// Bytes to receive before the next request. Precondition: is_skippable.
  std::uint64_t unread() const;
  /// Removes the bytes that were read from the input of the connection. To be called once, after
  /// the answer was written.
  void finish();

 private:
  /// Waits until there is something to receive. Returns false with a fault.
  bool wait_for_client();
  /// Receives a part of a stream's body. Returns false with a fault, or if there is nothing to wait
  /// for.
  bool receive(bool wait);
  /// Passes on what has arrived and was not read yet, decoded if necessary. Returns false if `sink`
  /// does.
  bool pass_on(const std::function<bool(std::span<const char>)>& sink);
  bool hand_on_decoded(const std::function<bool(std::span<const char>)>& sink);
  bool has_unread() const;

  Connection& connection_;
  ResponseWriter& writer_;
  Pace::Clock::time_point since_;  ///< time of the last byte, without the time of processing here
  Pace pace_, busy_pace_;
  std::uint64_t gathered_;       ///< unread bytes of a body in the connection's input
  std::size_t gathered_at_ = 0;  ///< their position there
  bool has_received_ = false;
  Fault fault_ = Fault::kNoFault;
  RequestMemory& memory_;
  std::unique_ptr<ContentDecoder> decoder_;  ///< null: the body is not compressed
  std::size_t decoder_bytes_ = 0;            ///< bytes that are counted for it
  std::string held_;                         ///< compressed bytes to be decoded
};

}  // namespace sightline

// Tests: tests/integration/abuse_framing_test.py
