#pragma once
/// IndexColumn: a column of indices of elements in another column. The common list 0, 1, 2, ...
/// takes no memory.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <span>
#include <type_traits>
#include <utility>

#include "core/base/shared_column.h"

namespace sightline {

/// A view of a list of indices, which must outlive the view, or of the sequence 0, 1, 2, ...
class IndexView {
 public:
  /// A forward iterator; compares equal by position, so both must be of one view.
  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = std::uint32_t;
    using difference_type = std::ptrdiff_t;
    using pointer = const std::uint32_t*;
    using reference = std::uint32_t;

    Iterator() = default;
    Iterator(const std::uint32_t* list, std::size_t at) : list_(list), at_(at) {}
    std::uint32_t operator*() const {
      return list_ != nullptr ? list_[at_] : static_cast<std::uint32_t>(at_);
    }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator operator++(int) { return {list_, at_++}; }
    bool operator==(const Iterator& other) const { return at_ == other.at_; }

   private:
    const std::uint32_t* list_ = nullptr;
    std::size_t at_ = 0;
  };

  IndexView() = default;
  /// Views a vector, a column or a span. An empty list is an empty view.
  template <class List>
  requires std::is_convertible_v<const List&, std::span<const std::uint32_t>> IndexView(
      const List& list) {
    const std::span<const std::uint32_t> span = list;
    list_ = span.data();
    size_ = span.size();
  }
  /// The sequence 0, 1, ... size - 1.
  static IndexView sequence(std::size_t size) {
    IndexView view;
    view.size_ = size;
    return view;
  }

  /// The list in memory; empty for a sequence.
  std::span<const std::uint32_t> listed() const {
    return {list_, list_ != nullptr ? size_ : std::size_t{0}};
  }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::uint32_t operator[](std::size_t i) const {
    return list_ != nullptr ? list_[i] : static_cast<std::uint32_t>(i);
  }
  /// The three indices of triangle t: elements 3t, 3t+1 and 3t+2.
  std::array<std::uint32_t, 3> corners(std::size_t t) const {
    if (list_ != nullptr) return {list_[3 * t], list_[3 * t + 1], list_[3 * t + 2]};
    const auto first = static_cast<std::uint32_t>(3 * t);
    return {first, first + 1, first + 2};
  }
  Iterator begin() const { return {list_, 0}; }
  Iterator end() const { return {list_, size_}; }
  bool operator==(const IndexView& other) const {
    if (list_ != nullptr && other.list_ != nullptr)
      return std::equal(list_, list_ + size_, other.list_, other.list_ + other.size_);
    return size_ == other.size_ && std::equal(begin(), end(), other.begin());
  }

 private:
  const std::uint32_t* list_ = nullptr;
  std::size_t size_ = 0;
};

/// A list of indices that owns its memory, shares it with an owner (SharedColumn), or is a sequence
/// 0, 1, 2, ... without a list. Several threads may read it while none writes.
class IndexColumn {
 public:
  IndexColumn() = default;
  IndexColumn(std::initializer_list<std::uint32_t> list) : list_(list) {}
  IndexColumn(SharedColumn<std::uint32_t> list) : list_(std::move(list)) {}
  /// The sequence 0, 1, ... size - 1. A size of 0 is an empty list.
  static IndexColumn sequence(std::size_t size) {
    IndexColumn column;
    column.sequence_ = size;
    return column;
  }

  operator IndexView() const {
    return sequence_ > 0 ? IndexView::sequence(sequence_) : IndexView(list_);
  }
  /// The list in memory; empty for a sequence.
  std::span<const std::uint32_t> listed() const { return list_; }
  std::size_t size() const { return sequence_ > 0 ? sequence_ : list_.size(); }
  bool empty() const { return size() == 0; }
  std::uint32_t operator[](std::size_t i) const { return IndexView(*this)[i]; }
  std::array<std::uint32_t, 3> corners(std::size_t t) const { return IndexView(*this).corners(t); }
  IndexView::Iterator begin() const { return IndexView(*this).begin(); }
  IndexView::Iterator end() const { return IndexView(*this).end(); }
  bool operator==(const IndexColumn& other) const { return IndexView(*this) == IndexView(other); }

  /// The indices as a list that may be written. A sequence becomes a list; a shared list is copied
  /// first.
  UnsetColumn<std::uint32_t>& own() {
    UnsetColumn<std::uint32_t>& list = list_.own();
    if (sequence_ > 0) list.assign(begin(), end());
    sequence_ = 0;
    return list;
  }
  /// Replaces the list by a sequence without memory if the list is 0, 1, 2, ... Cost: reads the
  /// list up to the first other number.
  void forget_sequence() {
    std::uint32_t next = 0;
    for (const std::uint32_t index : list_) {
      if (index != next++) return;
    }
    if (!list_.empty()) *this = sequence(list_.size());
  }

 private:
  SharedColumn<std::uint32_t> list_;
  std::size_t sequence_ = 0;  ///< size of the sequence; 0: the indices are in list_
};

}  // namespace sightline
