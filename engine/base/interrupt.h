#pragma once

namespace palpate {

/// From here on, the first SIGINT or SIGTERM asks the program to end and keep its
/// results; a second one ends it at once.
void catchInterrupts();

/// Whether a signal has asked for the end.
bool interrupted();

}  // namespace palpate
