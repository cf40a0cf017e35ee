#pragma once
/// The layout of a file of trees (tree_cache.h), for its encoder, its decoder and their tests.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "core/base/content_hash.h"
#include "core/bvh/wide_tree.h"

namespace sightline::tree_cache {

/// The version of the format and of the builder. It must be raised when either changes.
inline constexpr std::uint32_t kVersion = 5;
/// The first bytes of a file.
inline constexpr char kMagic[8] = {'S', 'L', 't', 'r', 'e', 'e', 's', '\n'};
/// Each arena begins at a multiple of this in the file.
inline constexpr std::size_t kAlign = kNodeAlign;

/// The first 128 bytes of a file. Members without a comment are set by make_header, and must be
/// equal on the machine that reads the file.
struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint32_t byte_order;
  std::uint32_t node_bytes, block_bytes, arity, lanes;
  std::uint64_t content;       ///< content_hash of the plan
  std::uint64_t file_bytes;    ///< size of the file
  std::uint64_t tree_count;    ///< number of records, that of the top tree included
  std::uint64_t records_hash;  ///< hash_of all records
  std::uint64_t reserved[7];
  std::uint64_t hash;  ///< hash_of the members above
};
static_assert(sizeof(Header) == 128);

/// Describes a tree. Members without a comment are those of WideTree.
struct Record {
  /// Position and size of the arena in the file.
  std::uint64_t offset, bytes;
  std::uint32_t root;
  std::int32_t scale_exponent;
  double lower[3], upper[3];
  std::uint32_t node_count, block_count, depth;
  std::uint32_t reserved[5];
  std::uint64_t reserved_too[2];
  std::uint64_t hash;  ///< hash_in_pieces of the arena
};
static_assert(sizeof(Record) == 128);

/// A header for this machine; counts and hashes are 0.
inline Header make_header() {
  Header header{};
  std::copy(std::begin(kMagic), std::end(kMagic), header.magic);
  header.version = kVersion;
  header.byte_order = 0x01020304;
  header.node_bytes = sizeof(WideNode);
  header.block_bytes = sizeof(LeafBlock);
  header.arity = kArity;
  header.lanes = kLanes;
  return header;
}

using sightline::hash_of;

/// The value of Header::hash.
inline std::uint64_t hash_of(const Header& header) {
  return hash_of(std::as_bytes(std::span(&header, 1)).first(offsetof(Header, hash)));
}

}  // namespace sightline::tree_cache

// Tests: tests/unit/scene/tree_cache_test.cpp
