#include "core/base/content_hash.h"

#include <algorithm>
#include <vector>

#include "core/base/parallel.h"

namespace sightline {

std::uint64_t hash_in_pieces(std::span<const std::byte> bytes) {
  std::vector<std::uint64_t> pieces((bytes.size() + kHashPiece - 1) / kHashPiece);
  parallel_for(pieces.size(), [&](std::size_t i) {
    pieces[i] =
        hash_of(bytes.subspan(i * kHashPiece, std::min(kHashPiece, bytes.size() - i * kHashPiece)));
  });
  return hash_of(std::as_bytes(std::span(pieces)));
}

}  // namespace sightline
