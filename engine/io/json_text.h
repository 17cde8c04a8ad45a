#pragma once

#include <string>

namespace palpate {

/// The first key that an object of a JSON text has twice, of which readers take the last; "": none has.
std::string doubledKey(const std::string& json);

}  // namespace palpate
