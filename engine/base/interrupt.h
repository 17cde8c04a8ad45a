#pragma once

namespace palpate {

/// From here on, the first SIGINT or SIGTERM asks the program to end and keep its results; a second one ends it at
/// once. SIGHUP (the terminal was closed) asks, too, however often it comes, unless the program was started with it
/// ignored. A file that reaches a limit of the system's is no signal, but a write that fails.
void catchInterrupts();

/// Whether a signal has asked for the end.
bool interrupted();

}  // namespace palpate
