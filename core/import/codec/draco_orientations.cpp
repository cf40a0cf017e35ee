#include "core/import/codec/draco_orientations.h"

#include <draco/compression/config/compression_shared.h>
#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/core/varint_decoding.h>

#include <vector>

namespace sightline::gltf {

namespace {

/// Passes over the corrections of an attribute: entropy-coded, or as they stand.
bool pass_corrections(draco::DecoderBuffer& buffer, std::uint64_t entries, int components) {
  const std::uint64_t values = entries * static_cast<std::uint64_t>(components);
  std::uint8_t is_compressed = 0;
  if (!buffer.Decode(&is_compressed)) return false;
  if (is_compressed != 0) {
    std::vector<std::uint32_t> symbols(values);
    return draco::DecodeSymbols(static_cast<std::uint32_t>(values), components, &buffer,
                                symbols.data());
  }
  std::uint8_t bytes_per_value = 0;
  if (!buffer.Decode(&bytes_per_value)) return false;
  const std::uint64_t bytes = values * bytes_per_value;
  if (bytes > static_cast<std::uint64_t>(buffer.remaining_size())) return false;
  buffer.Advance(static_cast<std::int64_t>(bytes));
  return true;
}

}  // namespace

std::uint64_t claimed_orientations(draco::DecoderBuffer buffer, std::uint64_t entries,
                                   int components) {
  if (buffer.decoded_size() < 2) return 0;
  const auto method = static_cast<unsigned char>(*(buffer.data_head() - 2));
  if (method == draco::MESH_PREDICTION_TEX_COORDS_PORTABLE) {
    std::int32_t count = 0;
    const bool is_there = pass_corrections(buffer, entries, components) && buffer.Decode(&count);
    return is_there && count > 0 ? static_cast<std::uint64_t>(count) : 0;
  }
  if (method == draco::MESH_PREDICTION_TEX_COORDS_DEPRECATED) {
    std::uint32_t count = 0;
    const bool is_there =
        pass_corrections(buffer, entries, components) && draco::DecodeVarint(&count, &buffer);
    return is_there ? count : 0;
  }
  return 0;
}

}  // namespace sightline::gltf
