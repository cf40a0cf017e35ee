#pragma once
/// Reads the body of one request off its connection, on a worker.

#include <cstdint>
#include <functional>
#include <span>

#include "server/chunk_decoder.h"
#include "server/connection.h"
#include "server/pace.h"

namespace sightline {

class ConnectionStream;

class BodyReader {
 public:
  enum class Fault {
    kNoFault,
    kEnded,  ///< the client stopped sending, or the chunks are none
    kSlow,   ///< it sends slower than it may
  };
  BodyReader(Connection& connection, ConnectionStream& stream, const PaceLimits& pace);

  /// Hands the body on in pieces until it ends (true), `sink` returns false, or there is a fault.
  bool read(const std::function<bool(std::span<const char>)>& sink);
  Fault fault() const { return fault_; }
  /// Whether it is known where the next request begins, and near enough to read up to there.
  bool is_skippable() const;
  /// Bytes up to there. Precondition: is_skippable.
  std::uint64_t unread() const { return left_; }

 private:
  bool is_over() const;
  /// Makes some input pending. False with a fault.
  bool wait_for_input();
  bool pass_on(const std::function<bool(std::span<const char>)>& sink);

  Connection& connection_;
  ConnectionStream& stream_;
  Pace pace_;
  ChunkDecoder chunks_;
  std::uint64_t left_;  ///< unread, of a body that is not chunked
  bool owes_continue_;  ///< the client waits for "100 Continue"
  Fault fault_ = Fault::kNoFault;
};

}  // namespace sightline
