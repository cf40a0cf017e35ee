#pragma once
/// JsonChecker: checks the members of a JSON document and remembers the first error, so that a
/// reader needs to test for errors only once, at the end.

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline::gltf {

/// A place in the document, as a linked list on the stack: `up` and `name` must outlive it. Its
/// text is built only for an error.
struct Place {
  static constexpr std::size_t kMember = std::numeric_limits<std::size_t>::max();
  const Place* up = nullptr;    ///< null: the document itself
  std::string_view name;        ///< name of the member
  std::size_t index = kMember;  ///< index of the element; kMember for a member

  Place member(std::string_view key) const { return {this, key, kMember}; }
  Place element(std::size_t i) const { return {this, {}, i}; }
  std::string pointer() const;  ///< "/nodes/5/mesh"
  std::string text() const;     ///< "nodes[5].mesh"
};

/// Checks one document: call its functions for each member, then test good(). `at` is the place of
/// `object` or `value`. Unless stated otherwise, an invalid member is the error GLTF_VALUE_INVALID.
///
/// An integer may be written as 3 or 3.0 [glTF2] 2.7.1; the checker rewrites it as 3. The magnitude
/// of a number is at most 2^53, because JSON readers disagree beyond that.
class JsonChecker {
 public:
  static constexpr std::uint64_t kMost = 1ull << 53;  ///< the largest magnitude of a number

  /// True if there was no error so far.
  bool good() const { return error_.code.empty(); }
  /// Returns the first error. Precondition: !good().
  Error take() { return std::move(error_); }
  /// Records an error unless there is one already.
  void refuse(Error error) {
    if (good()) error_ = std::move(error);
  }
  /// Records the error GLTF_VALUE_INVALID with the text "PLACE what", unless there is an error.
  void refuse(const Place& at, const std::string& what);

  /// Returns the member if it is an array (or object); nullptr if it is absent, or invalid, which
  /// is an error. Error: GLTF_VALUE_INVALID.
  nlohmann::json* array(nlohmann::json& object, const char* key, const Place& at);
  nlohmann::json* object(nlohmann::json& object, const char* key, const Place& at);
  /// True if a value is an object; otherwise records an error.
  bool is_object(const nlohmann::json& value, const Place& at);
  /// Checks that a member is a string (or boolean) if it is present.
  void text(const nlohmann::json& object, const char* key, const Place& at);
  void boolean(const nlohmann::json& object, const char* key, const Place& at);
  /// Checks that a member is an array of `count` numbers if it is present; 0 means any number of
  /// them.
  void numbers(const nlohmann::json& object, const char* key, const Place& at, std::size_t count);
  /// Returns an integer from 0 to `most`; empty if it is absent or invalid. `required_integer`
  /// returns 0 in these cases, and an absent member is an error.
  std::optional<std::uint64_t> integer(nlohmann::json& object, const char* key, const Place& at,
                                       std::uint64_t most = kMost);
  std::optional<std::uint64_t> integer(nlohmann::json& value, const Place& at,
                                       std::uint64_t most = kMost);
  std::uint64_t required_integer(nlohmann::json& object, const char* key, const Place& at,
                                 std::uint64_t most = kMost);
  /// Returns an index below `count`; empty if it is absent or invalid. `what` names the indexed
  /// things in the error. Error: GLTF_REFERENCE_INVALID.
  std::optional<std::uint64_t> reference(nlohmann::json& object, const char* key, const Place& at,
                                         std::size_t count, const char* what);
  void reference(nlohmann::json& value, const Place& at, std::size_t count, const char* what);
  /// Erases every member that is not in `keys`.
  static void keep_only(nlohmann::json& object, std::initializer_list<const char*> keys);

 private:
  Error error_;
};

/// Returns a member of what may be an object; null if there is none.
inline const nlohmann::json* member_of(const nlohmann::json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
