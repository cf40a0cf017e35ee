#include "proto/json/json_reader.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

Error error_of(simdjson::error_code code) {
  JsonReader reader;
  EXPECT_FALSE(reader.check_end(code, [] { return JsonPointer().key("rays"); }));
  return reader.error();
}

TEST(JsonReader, tells_a_lack_of_memory_from_a_fault_of_the_body) {
  const Error error = error_of(simdjson::MEMALLOC);
  EXPECT_EQ(error.kind, ErrorKind::kOutOfSpace);
  EXPECT_EQ(error.code, "MEMORY_FULL");
  EXPECT_EQ(error.pointer, "");
  EXPECT_EQ(error_of(simdjson::CAPACITY).kind, ErrorKind::kTooLarge);
  EXPECT_EQ(error_of(simdjson::TAPE_ERROR).kind, ErrorKind::kMalformed);
  EXPECT_EQ(error_of(simdjson::TAPE_ERROR).pointer, "/rays");
}

TEST(JsonReader, never_speaks_in_the_words_of_the_library) {
  for (int code = 1; code < simdjson::NUM_ERROR_CODES; ++code) {
    const auto known = static_cast<simdjson::error_code>(code);
    const std::string message = error_of(known).message;
    EXPECT_FALSE(message.empty());
    EXPECT_EQ(message.find(simdjson::error_message(known)), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace sightline
