#include "core/import/codec/draco_mesh.h"

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "core/import/codec/draco_orientations.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// Entropy coding has no least size: of a flat grid on exact steps, the most regular mesh there is,
/// 130,000 triangles take 350 bytes, and twice as many hardly more. So that a few bytes are no
/// lever, triangles beyond the first million need bytes of their own.
constexpr std::uint64_t kTrianglesForFree = 1u << 20;
constexpr std::uint64_t kTrianglesPerByte = 4096;

/// The decoder's memory per triangle, per triangle for each group of attributes with seams of its
/// own, and per value of an attribute. Measured on grids of 500,000 triangles: 46 to 91 bytes per
/// triangle with positions alone, 220 with texture coordinates and normals; rounded up.
constexpr std::uint64_t kBytesPerTriangle = 128;
constexpr std::uint64_t kBytesPerSeamTriangle = 48;
constexpr std::uint64_t kBytesPerValue = 16;

/// Each attribute may make the library fill tables of a million entries, whatever is in them: about
/// 20 bytes for 3 ms. glTF's primitives have a handful.
constexpr std::uint64_t kMostAttributes = 64;

/// Asked by the decoder below before it takes memory for triangles, and for attributes.
class Gate {
 public:
  Gate(const DracoClaim& claim, std::uint64_t compressed_bytes, Budget& budget)
      : claim_(claim), compressed_bytes_(compressed_bytes), budget_(budget) {}
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;
  ~Gate() { budget_.return_bytes(spent_); }

  bool refuse(std::string why) {
    if (why_.empty()) why_ = std::move(why);
    return false;
  }
  bool spend(std::uint64_t bytes) {
    if (Status status = budget_.spend_bytes(bytes); !status) {
      over_budget_ = status.error();
      return false;
    }
    spent_ += bytes;
    return true;
  }

  bool admits_triangles(std::uint64_t triangles, std::uint64_t seam_groups) {
    if (triangles != claim_.triangles) {
      return refuse("its bytes hold " + std::to_string(triangles) + " triangles, the accessors " +
                    std::to_string(claim_.triangles));
    }
    if (triangles > kTrianglesForFree + compressed_bytes_ * kTrianglesPerByte) {
      return refuse(std::to_string(compressed_bytes_) + " compressed bytes cannot hold " +
                    std::to_string(triangles) + " triangles");
    }
    return spend(triangles * (kBytesPerTriangle + seam_groups * kBytesPerSeamTriangle));
  }

  bool admits_points(std::uint64_t points) {
    if (points == claim_.points) return true;
    return refuse("its bytes hold " + std::to_string(points) + " points, the accessors " +
                  std::to_string(claim_.points));
  }

  bool admits_attributes(std::uint64_t attributes) {
    if (attributes <= kMostAttributes) return true;
    return refuse("its bytes hold " + std::to_string(attributes) + " attributes, the limit is " +
                  std::to_string(kMostAttributes));
  }

  bool admits_values(std::uint64_t per_point) {
    return spend(per_point * claim_.points * kBytesPerValue);
  }

  bool admits_orientations(std::uint64_t orientations, std::uint64_t entries) {
    if (orientations <= entries) return true;
    return refuse("its bytes hold " + std::to_string(orientations) + " orientations of " +
                  std::to_string(entries) + " texture coordinates");
  }

  bool wants(std::uint32_t attribute) const {
    return std::find(claim_.attributes.begin(), claim_.attributes.end(), attribute) !=
           claim_.attributes.end();
  }

  const std::optional<Error>& over_budget() const { return over_budget_; }
  const std::string& why() const { return why_; }

 private:
  const DracoClaim& claim_;
  std::uint64_t compressed_bytes_;
  Budget& budget_;
  std::uint64_t spent_ = 0;
  std::string why_;
  std::optional<Error> over_budget_;
};

/// What stands at the beginning of the connectivity of either kind.
struct Sizes {
  std::uint64_t triangles = 0;
  std::uint64_t seam_groups = 0;
};

std::optional<Sizes> edgebreaker_sizes(draco::DecoderBuffer buffer) {
  std::uint8_t seam_groups = 0;
  std::uint32_t vertices = 0, triangles = 0;
  if (!draco::DecodeVarint(&vertices, &buffer) || !draco::DecodeVarint(&triangles, &buffer) ||
      !buffer.Decode(&seam_groups)) {
    return std::nullopt;
  }
  return Sizes{triangles, seam_groups};
}

std::optional<Sizes> sequential_sizes(draco::DecoderBuffer buffer) {
  std::uint32_t triangles = 0;
  if (!draco::DecodeVarint(&triangles, &buffer)) return std::nullopt;
  return Sizes{triangles, 0};
}

/// A decoder of the library that asks the gate where it would take memory or time.
template <class Base>
class GatedDecoder : public Base {
 public:
  using ReadSizes = std::optional<Sizes> (*)(draco::DecoderBuffer);
  GatedDecoder(Gate& gate, ReadSizes read_sizes) : gate_(gate), read_sizes_(read_sizes) {}

  /// Asked by the library for each attribute of which it sets up a prediction from the mesh.
  /// Without this it takes another prediction, which costs little; what comes out is thrown away.
  const draco::MeshAttributeIndicesEncodingData* GetAttributeEncodingData(int id) const override {
    const auto* const data = Base::GetAttributeEncodingData(id);
    if (data == nullptr || attribute_bytes_ == nullptr) return data;
    const auto entries = static_cast<std::uint64_t>(data->num_values);
    const int components = this->point_cloud()->attribute(id)->num_components();
    const std::uint64_t orientations = claimed_orientations(*attribute_bytes_, entries, components);
    return gate_.admits_orientations(orientations, entries) ? data : nullptr;
  }

 protected:
  bool DecodeGeometryData() override {
    const auto sizes = read_sizes_(*this->buffer());
    if (!sizes.has_value()) return false;
    return gate_.admits_triangles(sizes->triangles, sizes->seam_groups) &&
           Base::DecodeGeometryData();
  }
  /// Attributes stand one after the other; those behind the last one that is wanted stay as they
  /// are.
  bool DecodeAllAttributes() override {
    const auto attributes = static_cast<std::uint64_t>(this->point_cloud()->num_attributes());
    if (!gate_.admits_points(this->point_cloud()->num_points())) return false;
    if (!gate_.admits_attributes(attributes)) return false;
    for (int i = 0; i <= last_wanted(); ++i) {
      // The library decodes through the same pointer, and stores it where a subclass cannot see it.
      auto* decoder = const_cast<draco::AttributesDecoderInterface*>(this->attributes_decoder(i));
      if (!gate_.admits_values(values_per_point(*decoder))) return false;
      attribute_bytes_ = this->buffer();
      if (!decoder->DecodeAttributes(this->buffer()) || !gate_.why().empty()) return false;
    }
    return true;
  }

 private:
  const draco::PointAttribute& attribute(const draco::AttributesDecoderInterface& decoder, int i) {
    return *this->point_cloud()->attribute(decoder.GetAttributeId(i));
  }
  int last_wanted() {
    int last = -1;
    for (int i = 0; i < this->num_attributes_decoders(); ++i) {
      const auto& decoder = *this->attributes_decoder(i);
      for (int k = 0; k < decoder.GetNumAttributes(); ++k) {
        if (gate_.wants(attribute(decoder, k).unique_id())) last = i;
      }
    }
    return last;
  }
  std::uint64_t values_per_point(const draco::AttributesDecoderInterface& decoder) {
    std::uint64_t values = 0;
    for (int k = 0; k < decoder.GetNumAttributes(); ++k) {
      values += static_cast<std::uint64_t>(attribute(decoder, k).num_components()) + 1;
    }
    return values;
  }

  Gate& gate_;
  ReadSizes read_sizes_;
  const draco::DecoderBuffer* attribute_bytes_ = nullptr;  ///< while attributes are decoded
};

/// The part of Draco's header that decides which decoder reads the rest.
struct Header {
  bool is_draco = false, is_mesh = false, is_version_2_2 = false, is_edgebreaker = false;
};

Header read_header(std::span<const std::byte> bytes) {
  if (bytes.size() < 11 || std::memcmp(bytes.data(), "DRACO", 5) != 0) return {};
  const auto at = [&](std::size_t i) { return std::to_integer<int>(bytes[i]); };
  return {true, at(7) == draco::TRIANGULAR_MESH, at(5) == 2 && at(6) == 2,
          at(8) == draco::MESH_EDGEBREAKER_ENCODING};
}

std::unique_ptr<draco::MeshDecoder> make_decoder(const Header& header, Gate& gate) {
  if (header.is_edgebreaker) {
    return std::make_unique<GatedDecoder<draco::MeshEdgebreakerDecoder>>(gate, edgebreaker_sizes);
  }
  return std::make_unique<GatedDecoder<draco::MeshSequentialDecoder>>(gate, sequential_sizes);
}

std::optional<Component> component_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return Component::kI8;
    case draco::DT_UINT8:
      return Component::kU8;
    case draco::DT_INT16:
      return Component::kI16;
    case draco::DT_UINT16:
      return Component::kU16;
    case draco::DT_UINT32:
      return Component::kU32;
    case draco::DT_FLOAT32:
      return Component::kF32;
    default:
      return std::nullopt;
  }
}

/// One element per point; nothing when the attribute does not reach so far or is of no glTF type.
std::optional<DecodedElements> unpack(const draco::PointAttribute& source, std::uint32_t points) {
  const auto component = component_of(source.data_type());
  if (!component.has_value() || source.buffer() == nullptr) return std::nullopt;
  DecodedElements out;
  out.component = *component;
  out.components = static_cast<std::uint32_t>(source.num_components());
  const std::size_t element = component_bytes(*component) * out.components;
  const auto stride = static_cast<std::size_t>(source.byte_stride());
  const auto offset = static_cast<std::size_t>(source.byte_offset());
  const std::size_t held = source.buffer()->data_size();
  if (!source.is_mapping_identity() && source.indices_map_size() < points) return std::nullopt;
  out.bytes.resize(element * points);
  for (std::uint32_t i = 0; i < points; ++i) {
    const std::size_t at = offset + stride * source.mapped_index(draco::PointIndex(i)).value();
    if (at + element > held) return std::nullopt;
    std::memcpy(out.bytes.data() + element * i, source.buffer()->data() + at, element);
  }
  return out;
}

}  // namespace

Result<DracoMesh> decode_draco(std::span<const std::byte> compressed, const DracoClaim& claim,
                               Budget& budget, const std::string& place,
                               const std::string& pointer) {
  const auto broken = [&](const std::string& what) {
    return invalid("GLTF_COMPRESSION_INVALID", place + ": " + kDraco + ": " + what, pointer);
  };
  const Header header = read_header(compressed);
  if (!header.is_draco) return broken("its bytes do not begin like Draco's");
  if (!header.is_mesh) return broken("its bytes hold points, not triangles");
  if (!header.is_version_2_2) return broken("only Draco's bitstream 2.2 can be read");

  Gate gate(claim, compressed.size(), budget);
  const auto decoder = make_decoder(header, gate);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(compressed.data()), compressed.size());
  draco::DecoderOptions options;
  draco::Mesh mesh;
  if (const draco::Status status = decoder->Decode(options, &buffer, &mesh); !status.ok()) {
    if (gate.over_budget().has_value()) return *gate.over_budget();
    return broken(!gate.why().empty() ? gate.why() : "its bytes are damaged");
  }

  DracoMesh out;
  out.points = mesh.num_points();
  if (mesh.num_faces() != claim.triangles || out.points != claim.points) {
    return broken("its bytes are damaged");
  }
  out.corners.reserve(claim.triangles * 3);
  for (std::uint32_t i = 0; i < mesh.num_faces(); ++i) {
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(i))) {
      if (corner.value() >= out.points) return broken("its bytes are damaged");
      out.corners.push_back(corner.value());
    }
  }
  for (const std::uint32_t id : claim.attributes) {
    const draco::PointAttribute* const source = mesh.GetAttributeByUniqueId(id);
    if (source == nullptr) return broken("its bytes hold no attribute " + std::to_string(id));
    auto attribute = unpack(*source, static_cast<std::uint32_t>(out.points));
    if (!attribute.has_value()) {
      return broken("attribute " + std::to_string(id) + " is of a type that glTF does not have");
    }
    out.attributes.emplace(id, *std::move(attribute));
  }
  return out;
}

}  // namespace sightline::gltf
