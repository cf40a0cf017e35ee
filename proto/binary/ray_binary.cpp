#include "proto/binary/ray_binary.h"

#include "proto/binary/binary_columns.h"
#include "proto/binary/hit_binary.h"
#include "proto/json/json_pointer.h"

namespace sightline {
namespace {

constexpr std::uint32_t kTmin = 2, kTmax = 4;
constexpr BinaryKind kRays{"SLR1", "rays", "RAYS_TOO_MANY", 7, [](std::uint32_t flags) {
                             return std::size_t{6} + ((flags & kTmin) != 0 ? 1u : 0u) +
                                    ((flags & kTmax) != 0 ? 1u : 0u);
                           }};

}  // namespace

Result<RayQuery> decode_rays_binary(std::string_view body, const RayJsonRules& rules,
                                    const RayQuery* usual) {
  const auto header = read_whole_header(body, kRays, rules.max_rays);
  if (!header) return header.error();

  RayJsonRules option_rules = rules;
  option_rules.has_rays = false;
  option_rules.default_fields = kDefaultBinaryFields;
  std::string options = options_of(body, *header);
  auto query = usual != nullptr && header->options_bytes == 0 ? Result<RayQuery>(*usual)
                                                              : decode_rays(options, option_rules);
  if (!query) return query;
  query->layout = AnswerLayout::kBinary;

  RayBatch& rays = query->rays;
  rays.resize(header->rows);
  std::size_t which = 0;
  for (UnsetColumn<double>* column : {&rays.ox, &rays.oy, &rays.oz, &rays.dx, &rays.dy, &rays.dz})
    read_column(body, *header, which++, *column);
  if ((header->flags & kTmin) != 0) read_column(body, *header, which++, rays.tmin);
  if ((header->flags & kTmax) != 0) read_column(body, *header, which++, rays.tmax);
  RayFault fault;
  if (!query->marks_invalid && !check_rays(rays, fault)) {
    return Error{ErrorKind::kInvalid, fault.code, fault.message,
                 JsonPointer().key("rays").index(fault.ray).key(fault.part).text()};
  }
  if (Status status = check_binary_fields(query->fields, query->named_fields); !status)
    return status.error();
  finish_rays(*query);
  return query;
}

}  // namespace sightline
