#pragma once

namespace palpate::tools {

/// Thrown to end a long step after Ctrl-C; what was written before stays.
struct Interrupted {};

}  // namespace palpate::tools
