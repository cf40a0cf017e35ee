#include "proto/binary/clearance_csv.h"

#include "proto/binary/hit_csv.h"

namespace sightline {

std::string encode_clearance_csv(const ClearanceAnswer& answer, const ClearanceQuestion& question,
                                 FieldSet fields, const ClearanceEnds& a, const ClearanceEnds& b) {
  std::string out = question.kinds ? "kind,depth,distance," : "distance,";
  const auto end_line = [&] {
    out.pop_back();
    out += "\r\n";
  };
  append_csv_names(out, "a.", {a.hits, a.details, a.terms}, fields);
  append_csv_names(out, "b.", {b.hits, b.details, b.terms}, fields);
  end_line();
  for (std::size_t i = 0; i < answer.pairs.size(); ++i) {
    const ClearancePair& pair = answer.pairs[i];
    if (question.kinds) {
      out.append(clash_kind_name(pair.kind)) += ',';
      append_csv_number(out, pair.depth);
    }
    append_csv_number(out, pair.distance);
    append_csv_cells(out, {a.hits, a.details, a.terms}, fields, i);
    append_csv_cells(out, {b.hits, b.details, b.terms}, fields, i);
    end_line();
  }
  return out;
}

}  // namespace sightline
