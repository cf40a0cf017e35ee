#pragma once
/// Checks of a JSON document that remember the first thing that is wrong, so that a reader can be
/// written straight down and ask once at the end.

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline::gltf {

/// A place in the document, linked on the stack; text is made only when something is wrong.
struct Place {
  static constexpr std::size_t kMember = std::numeric_limits<std::size_t>::max();
  const Place* up = nullptr;
  std::string_view name;        ///< of a member
  std::size_t index = kMember;  ///< of an element

  Place member(std::string_view key) const { return {this, key, kMember}; }
  Place element(std::size_t i) const { return {this, {}, i}; }
  std::string pointer() const;  ///< "/nodes/5/mesh"
  std::string text() const;     ///< "nodes[5].mesh"
};

/// Integers may be written as 3 or 3.0 [glTF2] 2.7.1; the checker rewrites them as 3. All numbers
/// are bounded by 2^53, beyond which JSON readers disagree.
class JsonChecker {
 public:
  static constexpr std::uint64_t kMost = 1ull << 53;

  bool good() const { return error_.code.empty(); }
  /// Precondition: !good().
  Error take() { return std::move(error_); }
  /// Only the first refusal counts.
  void refuse(Error error) {
    if (good()) error_ = std::move(error);
  }
  void refuse(const Place& at, const std::string& what);

  /// The member, or nullptr when absent or wrong. Error: GLTF_VALUE_INVALID.
  nlohmann::json* array(nlohmann::json& object, const char* key, const Place& at);
  nlohmann::json* object(nlohmann::json& object, const char* key, const Place& at);
  bool is_object(const nlohmann::json& value, const Place& at);
  /// Checks that a string member is one when present.
  void text(const nlohmann::json& object, const char* key, const Place& at);
  void boolean(const nlohmann::json& object, const char* key, const Place& at);
  /// An array of numbers; `count` 0 means any number of them.
  void numbers(const nlohmann::json& object, const char* key, const Place& at, std::size_t count);
  /// 0 <= integer <= most.
  std::optional<std::uint64_t> integer(nlohmann::json& object, const char* key, const Place& at,
                                       std::uint64_t most = kMost);
  std::optional<std::uint64_t> integer(nlohmann::json& value, const Place& at,
                                       std::uint64_t most = kMost);
  std::uint64_t required_integer(nlohmann::json& object, const char* key, const Place& at,
                                 std::uint64_t most = kMost);
  /// An index into `count` things called `what`. Error: GLTF_REFERENCE_INVALID.
  std::optional<std::uint64_t> reference(nlohmann::json& object, const char* key, const Place& at,
                                         std::size_t count, const char* what);
  void reference(nlohmann::json& value, const Place& at, std::size_t count, const char* what);
  /// Erases every other member.
  static void keep_only(nlohmann::json& object, std::initializer_list<const char*> keys);

 private:
  Error error_;
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
