#include "proto/ray_binary.h"

#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "proto/hit_binary.h"
#include "proto/json_pointer.h"

namespace sightline {
namespace {

static_assert(std::endian::native == std::endian::little, "columns are copied as they stand");

constexpr std::string_view kMagic = "SLR1";
constexpr std::size_t kHeaderBytes = 24;
constexpr std::uint32_t kFloat64 = 1, kTmin = 2, kTmax = 4, kKnownFlags = 7;

Error malformed(std::string message) {
  return {ErrorKind::kMalformed, "BINARY_MALFORMED", std::move(message), ""};
}

template <class T>
T read_at(std::string_view body, std::size_t at) {
  T value;
  std::memcpy(&value, body.data() + at, sizeof(T));
  return value;
}

template <class Number>
void read_column(std::string_view body, std::size_t at, Column<double>& column) {
  for (std::size_t i = 0; i < column.size(); ++i) {
    column[i] = static_cast<double>(read_at<Number>(body, at + i * sizeof(Number)));
  }
}

struct Header {
  std::uint32_t flags = 0;
  std::uint64_t rays = 0;
  std::uint32_t options_bytes = 0;
  std::size_t columns_at = 0;

  std::size_t number_bytes() const { return (flags & kFloat64) != 0 ? 8 : 4; }
  std::size_t columns() const {
    return 6u + ((flags & kTmin) != 0 ? 1u : 0u) + ((flags & kTmax) != 0 ? 1u : 0u);
  }
};

Result<Header> read_header(std::string_view body, std::size_t max_rays) {
  if (body.size() < kHeaderBytes) {
    return malformed("the header has 24 bytes, the body " + std::to_string(body.size()));
  }
  if (body.substr(0, kMagic.size()) != kMagic) return malformed("the body must begin with SLR1");
  Header header;
  header.flags = read_at<std::uint32_t>(body, 4);
  header.rays = read_at<std::uint64_t>(body, 8);
  header.options_bytes = read_at<std::uint32_t>(body, 16);
  if ((header.flags & ~kKnownFlags) != 0 || read_at<std::uint32_t>(body, 20) != 0) {
    return malformed("bits of the header that have no meaning must be zero");
  }
  if (header.rays > max_rays) {
    return Error{ErrorKind::kTooLarge, "RAYS_TOO_MANY",
                 "a request may hold " + std::to_string(max_rays) + " rays, this has " +
                     std::to_string(header.rays),
                 ""};
  }
  const std::size_t row = header.columns() * header.number_bytes();
  header.columns_at = (kHeaderBytes + std::size_t{header.options_bytes} + 7) / 8 * 8;
  if (header.rays > (std::numeric_limits<std::size_t>::max() - header.columns_at) / row ||
      body.size() != header.columns_at + header.rays * row) {
    return malformed("the header announces " + std::to_string(header.rays) + " rays of " +
                     std::to_string(row) + " bytes from byte " + std::to_string(header.columns_at) +
                     " on, the body has " + std::to_string(body.size()) + " bytes");
  }
  return header;
}

}  // namespace

Result<RayQuery> decode_rays_binary(std::string_view body, const RayJsonRules& rules) {
  const auto header = read_header(body, rules.max_rays);
  if (!header) return header.error();

  RayJsonRules option_rules = rules;
  option_rules.has_rays = false;
  option_rules.default_fields = kDefaultBinaryFields;
  std::string options(body.substr(kHeaderBytes, header->options_bytes));
  if (options.empty()) options = "{}";
  auto query = decode_rays(options, option_rules);
  if (!query) return query;
  query->layout = AnswerLayout::kBinary;

  RayBatch& rays = query->rays;
  rays.resize(header->rays);
  std::size_t at = header->columns_at;
  const auto read = [&](Column<double>& column) {
    if ((header->flags & kFloat64) != 0) {
      read_column<double>(body, at, column);
    } else {
      read_column<float>(body, at, column);
    }
    at += header->rays * header->number_bytes();
  };
  for (Column<double>* column : {&rays.ox, &rays.oy, &rays.oz, &rays.dx, &rays.dy, &rays.dz})
    read(*column);
  if ((header->flags & kTmin) != 0) read(rays.tmin);
  if ((header->flags & kTmax) != 0) read(rays.tmax);
  RayFault fault;
  if (!query->marks_invalid && !check_rays(rays, fault)) {
    return Error{ErrorKind::kInvalid, fault.code, fault.message,
                 JsonPointer().key("rays").index(fault.ray).key(fault.part).text()};
  }
  if (Status status = check_binary_fields(query->fields); !status) return status.error();
  finish_rays(*query);
  return query;
}

}  // namespace sightline
