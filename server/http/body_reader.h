#pragma once
/// Reads the body of one request off its connection, on a worker.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "server/http/chunk_decoder.h"
#include "server/http/connection.h"
#include "server/http/content_coding.h"
#include "server/http/pace.h"
#include "server/http/work_memory.h"

namespace sightline {

class ConnectionStream;

class BodyReader {
 public:
  enum class Fault {
    kNoFault,
    kEnded,   ///< the client stopped sending, or the chunks are none
    kSlow,    ///< it sends slower than it may
    kCoding,  ///< the body is not what its Content-Encoding says, or ends too early
    kMemory,  ///< there is no room now for what decodes it, or others wait for the room that it has
  };
  /// busy_rate  bytes per second, of a body that keeps others waiting for memory
  /// memory     where a decoder counts what it takes: a client says how much
  BodyReader(Connection& connection, ConnectionStream& stream, const PaceLimits& pace,
             std::uint64_t busy_rate, RequestMemory& memory);

  /// The body is compressed: pieces are handed on decoded. Once it is set it stays.
  void decode_as(Coding coding);
  bool decodes() const { return decoder_ != nullptr; }
  /// All of it was read: what decoded it goes.
  void end_decoding() { decoder_.reset(); }
  /// It may last as long as it likes, as long as it keeps its pace whenever somebody reads.
  void restart_pace();
  /// Hands the body on in pieces until it ends (true), `sink` returns false, or there is a fault.
  /// After a false of `sink` it may go on where it was. With `wait` false it ends as well (true)
  /// where nothing more has come.
  bool read(const std::function<bool(std::span<const char>)>& sink, bool wait = true);
  /// The rest of it, appended to `text`, with no copy between where it comes as it is. `admit` is
  /// asked before so many bytes are appended, for which it may make room, and may say no.
  bool read_all(std::string& text, const std::function<bool(std::size_t bytes)>& admit);
  /// Whether its end has come; after a read() that says true all of it was handed on.
  bool is_over() const;
  Fault fault() const { return fault_; }
  /// Whether some of it came only while it was read here.
  bool has_received() const { return has_received_; }
  /// Whether it is known where the next request begins, and near enough to read up to there.
  bool is_skippable() const;
  /// Bytes up to there. Precondition: is_skippable.
  std::uint64_t unread() const { return left_; }

 private:
  /// Until receive() gets something. False with a fault, or if nothing is to be waited for.
  bool get(const std::function<Received()>& receive, bool wait);
  /// Until there is something to receive. False with a fault.
  bool wait_for_client();
  void received(std::size_t bytes);
  /// Makes some input pending. The same.
  bool get_input(bool wait);
  bool hand_on_decoded(const std::function<bool(std::span<const char>)>& sink);
  bool pass_on(const std::function<bool(std::span<const char>)>& sink);

  Connection& connection_;
  ConnectionStream& stream_;
  Pace::Clock::time_point since_;  ///< when it last had something, which then was at work here
  Pace pace_, hurry_;
  ChunkDecoder chunks_;
  std::uint64_t left_;  ///< unread, of a body that is not chunked
  bool has_received_ = false;
  bool owes_continue_;  ///< the client waits for "100 Continue"
  Fault fault_ = Fault::kNoFault;
  RequestMemory& memory_;
  std::unique_ptr<ContentDecoder> decoder_;  ///< null: the body comes as it is
  std::size_t decoder_bytes_ = 0;            ///< that are counted
  std::string held_;                         ///< what is to be decoded
};

}  // namespace sightline
