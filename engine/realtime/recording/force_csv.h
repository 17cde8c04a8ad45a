#pragma once

#include <string>

#include "realtime/channels/snapshot.h"

namespace palpate {

/// force.csv: a row for each tick, the force on the tool and what belongs to it. Read it by the columns' names.
extern const char* const force_csv_header;

/// A row with its line end. Numbers have nine digits, which tell neighbouring floats apart; the clock's times have at
/// most 1e-4 s of detail.
std::string forceCsvRow(const ForceSample& sample);

}  // namespace palpate
