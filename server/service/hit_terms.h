#pragma once
/// Describes hits by the names and indices of the scene's file.

#include <span>
#include <string>

#include "core/base/deadline.h"
#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/run/engine.h"
#include "core/scene/scene.h"
#include "proto/json/hit_json.h"

namespace sightline {

/// Returns the columns for `fields`, each with one entry for each slot of `hits`. The names refer
/// to texts of the scene, which must outlive the result.
HitTerms hit_terms(const Scene& scene, const HitBatch& hits, FieldSet fields);

/// All data of hits that an answer needs besides their ids and t.
struct HitDescription {
  Column<HitDetail> details;
  HitTerms terms;
};

/// Hits to be described; refers to its parts. rays[i] belongs to slot i of `hits`; if `normalize`,
/// the t of the answer is the distance. `resolved` is the filter of the rays, for their costs.
struct DescribedHits {
  const Scene& scene;
  const RayBatch& rays;
  const HitBatch& hits;
  FieldSet fields;
  bool normalize = false;
  const ResolvedFilter* resolved = nullptr;
  std::span<const std::string> named = {};  ///< QueryOptions::named_fields
};

/// Sets terms.attributes for the fields, from `details`. Precondition: `details` are computed if the
/// fields have an attribute. Errors: those of Engine::attributes.
Status read_attributes(const Engine& engine, const DescribedHits& described,
                       const Deadline& deadline, HitDescription& description);

/// Computes all columns for the fields. Errors: those of Engine::details, mark_edges,
/// attributes and costs.
Status describe_hits(const Engine& engine, const DescribedHits& described, const Deadline& deadline,
                     HitDescription& description);

/// The ray of each hit of the lists, with its mask, for describe_hits.
RayBatch rays_of_hits(const RayBatch& rays, const HitLists& lists);

}  // namespace sightline
