#include "proto/binary/sweep_binary.h"

#include "proto/binary/binary_columns.h"
#include "proto/binary/ray_binary.h"

namespace sightline {
namespace {

constexpr std::uint32_t kTminFlag = 2, kTmaxFlag = 4, kBoxesFlag = 8;
constexpr BinaryKind kSweeps{"SLW1", "sweeps", "SWEEPS_TOO_MANY", 15, [](std::uint32_t flags) {
                               return std::size_t{6} + ((flags & kTminFlag) != 0 ? 1u : 0u) +
                                      ((flags & kTmaxFlag) != 0 ? 1u : 0u) +
                                      ((flags & kBoxesFlag) != 0 ? 3u : 1u);
                             }};

}  // namespace

Result<SweepQuery> decode_sweeps_binary(std::string_view body, const SweepJsonRules& rules) {
  const auto header = read_whole_header(body, kSweeps, rules.max_sweeps);
  if (!header) return header.error();
  SweepJsonRules option_rules = rules;
  option_rules.has_sweeps = false;
  option_rules.default_fields = kDefaultBinaryFields;
  std::string options = options_of(body, *header);
  auto query = decode_sweeps(options, option_rules);
  if (!query) return query;
  query->options.layout = AnswerLayout::kBinary;

  SweepBatch& sweeps = query->sweeps;
  RayBatch& rays = sweeps.rays;
  rays.resize(header->rows);
  std::size_t which = 0;
  for (UnsetColumn<double>* column : {&rays.ox, &rays.oy, &rays.oz, &rays.dx, &rays.dy, &rays.dz})
    read_column(body, *header, which++, *column);
  if ((header->flags & kTminFlag) != 0) read_column(body, *header, which++, rays.tmin);
  if ((header->flags & kTmaxFlag) != 0) read_column(body, *header, which++, rays.tmax);
  const bool are_boxes = (header->flags & kBoxesFlag) != 0;
  sweeps.size.resize(header->rows);
  sweeps.sphere.assign(header->rows, are_boxes ? 0 : 1);
  UnsetColumn<double> column(header->rows);
  for (int k = 0; k < (are_boxes ? 3 : 1); ++k) {
    read_column(body, *header, which++, column);
    for (std::size_t i = 0; i < column.size(); ++i) sweeps.size[i][k] = column[i];
  }
  SweepFault fault;
  if (!check_sweeps(sweeps, fault)) return error_of(fault);
  return query;
}

}  // namespace sightline
