#pragma once
/// SharedColumn<T>: elements that many threads read. They are written, if at all, before that.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <utility>

#include "core/base/column.h"

namespace sightline {

/// Owns its elements, or refers to memory that another object owns, such as a mapped file. Copies
/// share memory that is referred to.
template <class T>
class SharedColumn {
 public:
  SharedColumn() = default;
  SharedColumn(std::initializer_list<T> elements) : own_(elements) {}
  SharedColumn(UnsetColumn<T> elements) : own_(std::move(elements)) {}
  /// Refers to `elements`, which do not change while `owner` lives.
  SharedColumn(std::span<const T> elements, std::shared_ptr<const void> owner)
      : kept_(elements), owner_(std::move(owner)) {}

  operator std::span<const T>() const { return owner_ ? kept_ : std::span<const T>(own_); }
  std::size_t size() const { return owner_ ? kept_.size() : own_.size(); }
  bool empty() const { return size() == 0; }
  const T* data() const { return owner_ ? kept_.data() : own_.data(); }
  const T& operator[](std::size_t i) const { return data()[i]; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }
  bool operator==(const SharedColumn& other) const {
    return std::equal(begin(), end(), other.begin(), other.end());
  }

  /// For writing. Elements that are only referred to are copied first.
  UnsetColumn<T>& own() {
    if (owner_) {
      own_.assign(kept_.begin(), kept_.end());
      kept_ = {};
      owner_.reset();
    }
    return own_;
  }

 private:
  UnsetColumn<T> own_;
  std::span<const T> kept_;
  std::shared_ptr<const void> owner_;  ///< null: the column owns its elements
};

/// Bytes that do not change while `owner` lives.
struct SharedBytes {
  std::span<const std::byte> bytes = {};
  std::shared_ptr<const void> owner = {};  ///< null: the bytes may be freed
  /// Called with the bytes that share() returns; may be empty.
  std::function<void(std::span<const std::byte>)> claim = {};

  /// `count` elements at `from`, without a copy. Empty where these bytes do not hold them, or where
  /// they are not aligned for that.
  template <class T>
  SharedColumn<T> share(const std::byte* from, std::size_t count) const {
    const bool inside =
        owner != nullptr && !std::less<>()(from, bytes.data()) &&
        !std::less<>()(bytes.data() + bytes.size(), from) &&
        count <= static_cast<std::size_t>(bytes.data() + bytes.size() - from) / sizeof(T);
    if (!inside || reinterpret_cast<std::uintptr_t>(from) % alignof(T) != 0) return {};
    if (claim) claim({from, count * sizeof(T)});
    return {std::span(reinterpret_cast<const T*>(from), count), owner};
  }
};

}  // namespace sightline

// Tests: tests/unit/base/index_column_test.cpp
