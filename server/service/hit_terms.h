#pragma once
/// Translates the ids of hits into the scene's names and file indices.

#include "core/base/deadline.h"
#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/run/engine.h"
#include "core/scene/scene.h"
#include "proto/json/hit_json.h"

namespace sightline {

/// Fills the columns that `fields` asks for, and no others. The names point into the scene.
HitTerms hit_terms(const Scene& scene, const HitBatch& hits, FieldSet fields);

/// All that an answer says of hits beside their ids and t.
struct HitDescription {
  Column<HitDetail> details;
  HitTerms terms;
};

/// Fills terms.attributes, as far as `fields` asks for them, from `details`. Errors: those of
/// Engine::attributes.
Status read_attributes(const Engine& engine, const Scene& scene, const HitBatch& hits,
                       FieldSet fields, const Deadline& deadline, HitDescription& description);

/// Hits to be described. `rays[i]` belongs to slot i of `hits`; with `normalize` the t of the answer
/// is the distance.
struct DescribedHits {
  const Scene& scene;
  const RayBatch& rays;
  const HitBatch& hits;
  FieldSet fields;
  bool normalize = false;
};

/// Computes what `fields` asks for. Errors: those of Engine::details.
Status describe_hits(const Engine& engine, const DescribedHits& described, const Deadline& deadline,
                     HitDescription& description);

/// The ray of every hit in the lists: what Engine::details wants beside lists.hits.
RayBatch rays_of_hits(const RayBatch& rays, const HitLists& lists);

}  // namespace sightline
