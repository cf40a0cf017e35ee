#pragma once
/// The product's kernel without its last step: the same way through the tree and the same
/// decisions, but t as plain float64 arithmetic gives it. Shows what the correct rounding of t
/// costs and what it is good for.

#include "tests/contestants/textbook_kernel.h"

namespace sightline::contestants {

/// "sightline_unrounded", compiled for the best instruction set of this machine. Ids are those of
/// the product. Precondition of its closest: can_trace_unrounded(scene).
TextbookKernel unrounded_kernel();

/// What textbooks can trace, if the product takes its rays together.
bool can_trace_unrounded(const Scene& scene);

}  // namespace sightline::contestants
