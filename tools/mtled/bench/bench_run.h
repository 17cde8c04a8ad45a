#pragma once

#include <vector>

#include "mtled/bench/bench_body.h"
#include "mtled/bench/bench_report.h"

namespace palpate::tools {

/// 1, 2, 4 ... and `cores`.
std::vector<int> benchThreadCounts(int cores);

/// Holds every kernel of a body to the double reference, then times it beside the others: all kernels with
/// all thread counts of `ceilings` take turns, then the whole real-time step does with the ball pressed 3 mm in.
///
/// @param seconds         for each figure
/// @param with_reference  time the ten-line reference, too
/// Test: tools/bench_command_test.cpp
BenchBodyResult benchBody(const BenchSize& size, const std::vector<Ceilings>& ceilings, double seconds,
                          bool with_reference);

}  // namespace palpate::tools
