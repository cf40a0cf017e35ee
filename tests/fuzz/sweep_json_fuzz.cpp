// Bodies of sweeps, JSON or bytes, and of clearance: an error with a place, or a query that has
// passed the border and that another parser reads alike.
// Run:  scripts/stress.sh fuzz --target sweep_json_fuzz

#include <string>

#include "proto/binary/sweep_binary.h"
#include "proto/json/clearance_json.h"
#include "proto/json/sweep_json.h"
#include "tests/fuzz/body_check.h"

using namespace sightline;

namespace {

void check_sweeps_of(const SweepBatch& sweeps) {
  SweepFault fault;
  fuzz::require(check_sweeps(sweeps, fault), "sweeps have passed the border");
  fuzz::require(sweeps.count() <= 64 && sweeps.rays.size() == sweeps.count() &&
                    sweeps.sphere.size() == sweeps.count(),
                "columns are of one length, within the limit");
}

void check_rows_of(const nlohmann::json& rows, const SweepBatch& sweeps) {
  fuzz::check_rows(rows, sweeps.rays);
  for (std::size_t i = 0; i < sweeps.count(); ++i) {
    const bool is_sphere = sweeps.sphere[i] != 0;
    fuzz::require(rows[i].contains("radius") == is_sphere, "spheres have a radius");
    if (is_sphere) {
      fuzz::require(fuzz::same(rows[i]["radius"], sweeps.size[i].x), "radii read alike");
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      fuzz::require(fuzz::same(rows[i]["half"][static_cast<std::size_t>(k)], sweeps.size[i][k]),
                    "half extents read alike");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const std::string sent(reinterpret_cast<const char*>(data), size);
  std::string body = sent;
  const SweepJsonRules rules{.max_sweeps = 64, .has_fields = size % 2 == 0};
  const auto sweeps = decode_sweeps(body, rules);
  require(body == sent, "the body is only read");
  if (sweeps) {
    check_sweeps_of(sweeps->sweeps);
    check_rows_of(nlohmann::json::parse(sent, nullptr, false)["sweeps"], sweeps->sweeps);
  } else {
    fuzz::check_error(sweeps.error());
  }
  const auto bytes = decode_sweeps_binary(sent, rules);
  if (bytes) {
    check_sweeps_of(bytes->sweeps);
  } else {
    fuzz::check_error(bytes.error());
  }
  const auto clearance = decode_clearance(body, 1000);
  require(body == sent, "the body is only read");
  if (clearance) {
    const ClearanceQuestion& question = clearance->question;
    require(question.max_distance >= 0 && question.limit <= 1000, "numbers are in range");
    const auto document = nlohmann::json::parse(sent, nullptr, false);
    require(document.contains("a") && document.contains("b"), "both were chosen");
    if (const auto* most = fuzz::find(document, "max_distance"); most && !most->is_null())
      require(fuzz::same(*most, question.max_distance), "distances read alike");
  } else {
    fuzz::check_error(clearance.error());
  }
  return 0;
}
