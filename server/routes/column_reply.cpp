#include "server/routes/column_reply.h"

#include <utility>

#include "proto/binary/column_table.h"
#include "proto/binary/ray_binary.h"

namespace sightline {

std::optional<TableFormat> wanted_table(const Exchange& exchange, bool has_clouds) {
  for (std::size_t i = 0; i < kTableMediaTypes.size(); ++i) {
    const auto format = static_cast<TableFormat>(i);
    if (exchange.wants(kTableMediaTypes[i]) && (has_clouds || !is_point_cloud(format)))
      return format;
  }
  return std::nullopt;
}

Result<std::string> table_of_columns(const Exchange& exchange, TableFormat format,
                                     const std::string& answer) {
  if (Status status = exchange.reserve(bytes_of_column_table(answer)); !status)
    return std::move(status).error();
  return encode_column_table(format, answer);
}

bool wants_columns(const Exchange& exchange) {
  return exchange.wants(kBinaryMediaType) || wanted_table(exchange, false).has_value();
}

void reply_encoded_columns(Exchange& exchange, std::string answer) {
  const auto format = wanted_table(exchange, false);
  if (!format) return exchange.reply(200, std::move(answer), kBinaryMediaType);
  auto table = table_of_columns(exchange, *format, answer);
  if (!table) return exchange.reply_error(table.error());
  exchange.reply(200, std::move(*table), table_media_type(*format));
}

}  // namespace sightline
