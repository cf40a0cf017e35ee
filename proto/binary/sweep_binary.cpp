#include "proto/binary/sweep_binary.h"

#include "proto/binary/binary_columns.h"
#include "proto/binary/ray_binary.h"

namespace sightline {
namespace {

constexpr std::uint32_t kTminFlag = 2, kTmaxFlag = 4, kBoxesFlag = 8, kMoreFlag = 16;
constexpr BinaryKind kSweeps{"SLW1", "sweeps", "SWEEPS_TOO_MANY", 31, [](std::uint32_t flags) {
                               return std::size_t{6} + ((flags & kTminFlag) != 0 ? 1u : 0u) +
                                      ((flags & kTmaxFlag) != 0 ? 1u : 0u) +
                                      ((flags & kBoxesFlag) != 0 ? 3u : 1u) +
                                      ((flags & kMoreFlag) == 0    ? 0u
                                       : (flags & kBoxesFlag) != 0 ? 9u
                                                                   : 3u);
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
  const bool have_more = (header->flags & kMoreFlag) != 0;
  sweeps.shape.assign(header->rows, are_boxes
                                        ? have_more ? SweepShape::kOrientedBox : SweepShape::kBox
                                    : have_more ? SweepShape::kCapsule
                                                : SweepShape::kSphere);
  sweeps.number.resize(header->rows);
  for (std::size_t i = 0; i < header->rows; ++i) sweeps.number[i] = static_cast<std::uint32_t>(i);
  UnsetColumn<double> column(header->rows);
  for (int k = 0; k < (are_boxes ? 3 : 1); ++k) {
    read_column(body, *header, which++, column);
    for (std::size_t i = 0; i < column.size(); ++i) sweeps.size[i][k] = column[i];
  }
  if (have_more && are_boxes) sweeps.axes.resize(header->rows);
  if (have_more && !are_boxes) sweeps.ends.resize(header->rows);
  for (std::size_t k = 0; have_more && k < (are_boxes ? 9u : 3u); ++k) {
    read_column(body, *header, which++, column);
    const int axis = static_cast<int>(k % 3);
    for (std::size_t i = 0; i < column.size(); ++i)
      (are_boxes ? sweeps.axes[i][k / 3] : sweeps.ends[i])[axis] = column[i];
  }
  SweepFault fault;
  if (!check_sweeps(sweeps, fault)) return error_of(fault);
  return query;
}

}  // namespace sightline
