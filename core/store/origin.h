#pragma once
/// Origin: an object store that several servers share. It holds the truth about their scenes; the
/// data folder of each server is a cache of it.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/store/posix_file.h"

namespace sightline {

/// An object that list() found.
struct OriginObject {
  std::string name;
  std::uint64_t bytes = 0;
};

/// Named objects that are created once and never change. Names are relative paths of letters,
/// digits, '.', '_', '-' and '/'. Functions block until the store answers; they are thread-safe.
/// Errors of all functions: ORIGIN_UNREACHABLE (no answer, or the answer says: later),
/// ORIGIN_REFUSED (the credentials or the address are wrong), ORIGIN_ANSWER (an answer that such a
/// store does not give), those of io_error. After an error of create() the object may exist.
class Origin {
 public:
  virtual ~Origin() = default;

  /// Makes an object, durably. Returns false, and changes nothing, if there is one of this name: of
  /// several callers at once, exactly one gets true.
  virtual Result<bool> create(const std::string& name, std::string_view content) = 0;
  /// Makes an object of the first `bytes` bytes of a file, as above.
  virtual Result<bool> create(const std::string& name, const FileDescriptor& file,
                              std::uint64_t bytes) = 0;
  /// Passes an object to `sink`, in pieces that are valid during the call. Returns false if there
  /// is none. Errors: also those of `sink`.
  virtual Result<bool> read(const std::string& name,
                            const std::function<Status(std::span<const std::byte>)>& sink) = 0;
  /// Returns the objects whose names begin with `prefix` and are greater than `after`, sorted by
  /// name. `prefix` is empty or ends with '/'.
  virtual Result<std::vector<OriginObject>> list(const std::string& prefix,
                                                 const std::string& after) = 0;
  /// Removes an object. It is no error if there is none.
  virtual Status remove(const std::string& name) = 0;
};

}  // namespace sightline

// Tests: tests/unit/store/origin_test.cpp
