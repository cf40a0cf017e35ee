#pragma once
/// Rays as requests, in each form that the server takes.

#include <array>
#include <string>
#include <string_view>

#include "core/query/ray_batch.h"
#include "proto/hit_fields.h"

namespace sightline::bench {

enum class Form { kRows, kColumns, kLines, kBinary };
inline constexpr std::array kForms{Form::kRows, Form::kColumns, Form::kLines, Form::kBinary};
std::string_view form_name(Form form);

/// What every request asks for.
inline constexpr FieldSet kBenchFields{HitField::kT, HitField::kInstance, HitField::kPrimitive,
                                       HitField::kTriangle};

/// The body; binary is float64. Origins and directions, no limits.
std::string body_of(const RayBatch& rays, Form form);
/// POST of that body to /v1/scenes/bench/rays:closest.
std::string request_of(const std::string& body, Form form);

}  // namespace sightline::bench
