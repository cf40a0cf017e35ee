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
                    sweeps.shape.size() == sweeps.count(),
                "columns are of one length, within the limit");
}

void check_vector(const nlohmann::json& numbers, const Vec3d& read) {
  for (int k = 0; k < 3; ++k)
    fuzz::require(fuzz::same(numbers[static_cast<std::size_t>(k)], read[k]), "vectors read alike");
}

/// The rows of rays: the path of a capsule begins at its first end.
nlohmann::json with_origins(nlohmann::json rows) {
  for (auto& row : rows)
    if (row.contains("from")) row["origin"] = row["from"];
  return rows;
}

void check_rows_of(const nlohmann::json& rows, const SweepBatch& sweeps) {
  fuzz::check_rows(with_origins(rows), sweeps.rays);
  for (std::size_t i = 0; i < sweeps.count(); ++i) {
    const SweepShape shape = sweeps.shape[i];
    const bool is_round = shape == SweepShape::kSphere || shape == SweepShape::kCapsule;
    fuzz::require(rows[i].contains("radius") == is_round, "round shapes have a radius");
    fuzz::require(rows[i].contains("to") == (shape == SweepShape::kCapsule), "capsules have ends");
    if (is_round) {
      fuzz::require(fuzz::same(rows[i]["radius"], sweeps.size[i].x), "radii read alike");
    } else {
      check_vector(rows[i]["half"], sweeps.size[i]);
    }
    if (shape == SweepShape::kCapsule) check_vector(rows[i]["to"], sweeps.ends[sweeps.number[i]]);
    if (rows[i].contains("axes")) {
      for (std::size_t k = 0; k < 3; ++k)
        check_vector(rows[i]["axes"][k], sweeps.axes[sweeps.number[i]][k]);
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
