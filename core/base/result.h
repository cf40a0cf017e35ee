#pragma once
/// Result<T>: a value of type T, or an Error that says what the caller may do about it. The
/// compilers of Debian 12 lack <expected> in C++20 mode; this is the small part of it that
/// Sightline uses.

#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace sightline {

/// What the caller may do, as a short closed list. The server maps each kind to an HTTP status.
enum class ErrorKind {
  kInvalid,       ///< the input is wrong and must be corrected (422)
  kMalformed,     ///< the input is not in the format that it claims to be in (400)
  kUnsupported,   ///< the input is valid, but needs something that Sightline does not have (415)
  kTooLarge,      ///< a limit would be exceeded (413)
  kNotFound,      ///< the thing does not exist (404)
  kConflict,      ///< not possible in the present state; try again later (409)
  kPrecondition,  ///< the state is not what the caller expects (412)
  kCancelled,     ///< the caller disconnected or asked to stop (503)
  kDeadline,      ///< the time allowed was used up (504)
  kBusy,          ///< too much work is under way; try again later (503)
  kOutOfSpace,    ///< disk or memory budget is full (507)
  kInternal,      ///< a fault of Sightline (500)
};

/// An error for the caller.
struct Error {
  ErrorKind kind = ErrorKind::kInternal;
  /// Stable, machine readable, in upper case: RAY_DIRECTION_ZERO. A released code never changes.
  std::string code;
  /// One sentence for people, with the place and both numbers: "accessor 7: needs 1200 bytes, view
  /// has 900". Never contains a path of this machine.
  std::string message;
  /// JSON pointer to the offending part of the input, or empty.
  std::string pointer;
};

/// Holds a value or an error; never both, never neither. Both constructors are implicit, so a
/// function returns either directly. A wrong access throws std::bad_variant_access.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  /// The value. Precondition: ok().
  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  /// The error. Precondition: !ok().
  const Error& error() const& { return std::get<1>(state_); }
  Error&& error() && { return std::get<1>(std::move(state_)); }

 private:
  std::variant<T, Error> state_;
};

/// The value of a Result that has nothing to say but success.
struct Unit {};
/// The result of a function that returns success or an error.
using Status = Result<Unit>;
/// A Status without an error.
inline Status success() { return Unit{}; }

}  // namespace sightline

// Tests: tests/unit/proto/problem_test.cpp
