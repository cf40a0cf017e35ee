#pragma once
/// SharedColumn<T>: a column that many threads read. No thread may call own() while others read it.

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

/// Owns its elements, or refers to memory of another object such as a file in memory. Copies of a
/// column that refers share that memory; copies of a column that owns are deep.
template <class T>
class SharedColumn {
 public:
  SharedColumn() = default;
  SharedColumn(std::initializer_list<T> elements) : own_(elements) {}
  SharedColumn(UnsetColumn<T> elements) : own_(std::move(elements)) {}
  /// Refers to `elements`, which must not change while `owner` lives. A null `owner` gives an empty
  /// column.
  SharedColumn(std::span<const T> elements, std::shared_ptr<const void> owner)
      : kept_(elements), owner_(std::move(owner)) {}

  /// A column whose copies share the elements.
  static SharedColumn shared(UnsetColumn<T> elements) {
    const auto owner = std::make_shared<const UnsetColumn<T>>(std::move(elements));
    return {std::span<const T>(*owner), owner};
  }

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

  /// The elements for writing. If the column only refers to them, it first copies them, and may
  /// throw std::bad_alloc.
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
  /// null: the bytes may be freed at any time, and share() returns an empty column
  std::shared_ptr<const void> owner = {};
  /// Called by share() with the bytes of each column that it returns, so that their owner retains
  /// them. Called on the thread of share(). Empty: not called.
  std::function<void(std::span<const std::byte>)> claim = {};

  /// A column of `count` elements at `from` that refers to these bytes. Empty if there is no owner,
  /// if the elements are not wholly inside of these bytes, or if `from` is not aligned for T.
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
