#pragma once
/// Result<T>: a value, or an Error that says what the caller may do about it.
/// Debian 12's compilers lack <expected> in C++20 mode; this is the small part of it that we use.

#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace sightline {

/// What the caller may do, in a short closed list. The server maps each to one HTTP status.
enum class ErrorKind {
  kInvalid,       ///< the input is wrong: mend it (422)
  kMalformed,     ///< the input is not even the format it claims to be (400)
  kUnsupported,   ///< a valid input that needs something we do not have (415)
  kTooLarge,      ///< a limit would be exceeded (413)
  kNotFound,      ///< no such thing (404)
  kConflict,      ///< not in this state, try again later (409)
  kPrecondition,  ///< not what the caller believes it to be (412)
  kCancelled,     ///< the caller went away or asked to stop
  kDeadline,      ///< the time allowed was used up (504)
  kBusy,          ///< too much is under way: try again later (503)
  kOutOfSpace,    ///< disk or memory budget is full (507)
  kInternal,      ///< our fault (500)
};

struct Error {
  ErrorKind kind = ErrorKind::kInternal;
  /// Stable, machine readable, upper case: RAY_DIRECTION_ZERO. Never changes once released.
  std::string code;
  /// One sentence for people, with the place and both numbers: "accessor 7: needs 1200 bytes, view
  /// has 900". Never a path of this machine.
  std::string message;
  /// JSON pointer to the offending part of the input, or empty.
  std::string pointer;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  /// Precondition for all of these: ok().
  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  /// Precondition: !ok().
  const Error& error() const& { return std::get<1>(state_); }
  Error&& error() && { return std::get<1>(std::move(state_)); }

 private:
  std::variant<T, Error> state_;
};

struct Unit {};
using Status = Result<Unit>;
inline Status success() { return Unit{}; }

}  // namespace sightline

// Tests: tests/unit/proto/problem_test.cpp
