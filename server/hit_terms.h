#pragma once
/// What the ids of hits mean in the scene's own terms.

#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene.h"
#include "proto/hit_json.h"

namespace sightline {

/// Fills the columns that `fields` asks for, and no others. The names point into the scene.
HitTerms hit_terms(const Scene& scene, const HitBatch& hits, FieldSet fields);

/// The ray of every hit in the lists: what Engine::details wants beside lists.hits.
RayBatch rays_of_hits(const RayBatch& rays, const HitLists& lists);

}  // namespace sightline
