#pragma once

#include "mtled/bench/bench_report.h"
#include "mtled/report/pictures.h"

namespace palpate::tools {

/// One core's roofline (Williams, Waterman, Patterson 2009): what the ceilings allow over arithmetic intensity, with
/// a roof per
/// memory level under the widest float32 multiply-add peak, and where each one-thread row lies below them.
/// @pre  the report has ceilings of one thread
Figure rooflineOf(const BenchReport& report);

}  // namespace palpate::tools
