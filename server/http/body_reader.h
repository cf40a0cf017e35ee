#pragma once
/// Reads the body of one request, on a worker.

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

/// Only a stream waits for its client. For all others the event loop receives the body, and a
/// handler is called again when it is there: see ask_for.
class BodyReader {
 public:
  enum class Fault {
    kNoFault,
    kEnded,   ///< the client stopped sending, or the chunks are malformed
    kSlow,    ///< it sends slower than it may
    kCoding,  ///< the body is not what its Content-Encoding says, or ends too early
    kMemory,  ///< there is no room now for what decodes it, or others wait for the room that it has
    kDisk,    ///< the temporary file that holds it cannot be read
  };
  /// busy_rate  bytes per second: the least rate of a stream while other requests wait for memory
  /// memory     counts what a decoder takes, since a client chooses how much
  BodyReader(Connection& connection, ResponseWriter& writer, const PaceLimits& pace,
             std::uint64_t busy_rate, RequestMemory& memory);

  /// Whether `bytes` of the body can be read, as they came, or all of it. Where not the request is
  /// put off: the handler returns without an answer and is called again when they have come.
  bool ask_for(std::uint64_t bytes);
  /// Whether this runs on a thread that may wait for the client. Where not the request is put off
  /// until such a thread is free, likewise.
  bool may_wait();
  /// Whether a request of that cost may go on here: short ones anywhere, long ones on a worker for
  /// long requests. Where not the request is put off until one of those is free, likewise.
  /// cost  in rays of an ordinary query
  bool may_cost(std::uint64_t cost);
  bool is_put_off() const { return connection_.put_off != Connection::PutOff::kNo; }
  /// State of the handler of a request that was put off. While it is not null, the event loop calls
  /// again for each part of the body that has arrived, and parts that were read do not come again.
  std::shared_ptr<void>& kept() { return connection_.kept; }
  /// Bytes that were read of the parts before this one.
  std::uint64_t read_before() const { return connection_.body ? connection_.body->dropped() : 0; }
  /// All that has come was read. The request is put off until the next part has come.
  void ask_for_next_part();

  /// The body is compressed: pieces are handed on decoded. Once it is set it stays.
  void decode_as(Coding coding);
  bool decodes() const { return decoder_ != nullptr; }
  /// All of it was read: what decoded it goes. The body stays, because a request may be repeated.
  void end_decoding() {
    decoder_.reset();
    memory_.unpin();
  }
  /// A stream may last for any time, as long as the client sends at the least rate while the server
  /// reads.
  void restart_pace();
  /// Hands the body on in pieces until it ends (true), `sink` returns false, or there is a fault.
  /// After a false of `sink` it may go on where it was. It ends as well (true) where nothing more
  /// has come; a stream waits for more, but not with `wait` false.
  bool read(const std::function<bool(std::span<const char>)>& sink, bool wait = true);
  /// The rest of it, appended to `text`, with no copy between. `admit` is asked before so many
  /// bytes are appended, for which it may make room, and may say no.
  bool read_all(std::string& text, const std::function<bool(std::size_t bytes)>& admit);
  /// Bytes that read_all will append, where that is known.
  std::optional<std::uint64_t> unread_bytes() const;
  /// Whether its end has come; after a read() that says true all of it was handed on.
  bool is_over() const;
  Fault fault() const { return fault_; }
  /// Whether some of it came only while it was read here.
  bool has_received() const { return has_received_; }
  /// Whether it is known where the next request begins, and near enough to read up to there.
  bool is_skippable() const;
  /// Bytes up to there that are still to come. Precondition: is_skippable.
  std::uint64_t unread() const;
  /// The answer is ready: what was read goes from the connection.
  void finish();

 private:
  /// Until there is something to receive. False with a fault.
  bool wait_for_client();
  /// Receives some of a stream's body. False with a fault, or if nothing is to be waited for.
  bool receive(bool wait);
  /// Hands on what has come and was not read yet, decoded or not. False where `sink` returns false.
  bool pass_on(const std::function<bool(std::span<const char>)>& sink);
  bool hand_on_decoded(const std::function<bool(std::span<const char>)>& sink);
  bool has_unread() const;

  Connection& connection_;
  ResponseWriter& writer_;
  Pace::Clock::time_point since_;  ///< when it last had something, which then was at work here
  Pace pace_, busy_pace_;
  std::uint64_t gathered_;       ///< unread bytes of a body that stands in the connection's input
  std::size_t gathered_at_ = 0;  ///< where they begin there
  bool has_received_ = false;
  Fault fault_ = Fault::kNoFault;
  RequestMemory& memory_;
  std::unique_ptr<ContentDecoder> decoder_;  ///< null: the body comes as it is
  std::size_t decoder_bytes_ = 0;            ///< that are counted
  std::string held_;                         ///< what is to be decoded
};

}  // namespace sightline
